"""The loops and the plant as a linear map, its power over a cycle, and a bound on what the steps can reach.

The states are e, v, i and T, then twist and speed of an elastic load; the inputs are the set speed, `d`, the current
feed-forward, and `f` with an elastic load (all as in `loops`).
"""

from functools import lru_cache

from fieldrig_devices.drives.loops import INNER_S, Gains, Limits, Plant, plant_step
from fieldrig_devices.drives.matrices import Matrix, Row, identity, product

E, V, INTEGRAL, T, TWIST, LOAD = range(6)
SET_SPEED, D, LEAD, FRICTION = range(4)


@lru_cache(maxsize=256)
def fold(plant: Plant, gains: Gains, limits: Limits, steps: int) -> tuple[Matrix, Row]:
    """Return the map of a whole cycle, and the weights of `_weights`.

    The map's rows are the states.  Its columns are the states too: it maps their distances from the steady state.
    """
    states = 6 if plant.elastic else 4
    step = step_matrix(plant, gains)
    power = identity(len(step))
    for _ in range(steps):
        power = product(step, power)
    return [row[:states] for row in power[:states]], _weights(plant, gains, limits, step, steps)


def step_matrix(plant: Plant, gains: Gains) -> Matrix:
    """Return the map of one inner step: from states and inputs to states and the same inputs."""
    states, inputs = (6, 4) if plant.elastic else (4, 3)
    way, speed, torque, *load_rows = plant_step(plant)
    size = states + inputs
    # The set torque and the growth of the integral part, as rows over states and inputs.
    set_torque = _set_torque_row(gains, states) + [0.0] * inputs
    set_torque[states + SET_SPEED], set_torque[states + LEAD] = gains.kp * gains.ff, 1.0
    growth = [0.0] * size
    growth[E], growth[V] = gains.ki * gains.kv * INNER_S, -gains.ki * INNER_S
    growth[states + SET_SPEED] = gains.ki * gains.ff * INNER_S

    def row_of(plant_row: Row) -> Row:
        row = [plant_row[-3] * x for x in set_torque]
        row[V] += plant_row[1]
        row[T] += plant_row[2]
        if states == 6:
            row[TWIST] += plant_row[3]
            row[LOAD] += plant_row[4]
            row[states + FRICTION] += plant_row[-1]
        row[states + D] += plant_row[-2]
        return row

    error = [-x for x in row_of(way)]
    error[E] += 1.0
    error[states + SET_SPEED] += INNER_S
    growth[INTEGRAL] += 1.0
    rows = [error, row_of(speed), growth, row_of(torque), *(row_of(load_row) for load_row in load_rows)]
    return rows + identity(size)[states:]


def _weights(plant: Plant, gains: Gains, limits: Limits, step: Matrix, steps: int) -> Row:
    """Return, per state, the share of a limit that a unit of distance from the steady state uses at most in a step."""
    states = 6 if plant.elastic else 4
    torque = reach(step, states, steps, _set_torque_row(gains, states))
    speed = reach(step, states, steps, [float(state == V) for state in range(states)])
    set_speed = reach(step, states, steps, [gains.kv if state == E else 0.0 for state in range(states)])
    if plant.elastic:
        load = reach(step, states, steps, [float(state == LOAD) for state in range(states)])
        speed = [max(pair) for pair in zip(speed, load, strict=True)]
    return [
        max(a / limits.torque, b / limits.speed, c / limits.speed)
        for a, b, c in zip(torque, speed, set_speed, strict=True)
    ]


def _set_torque_row(gains: Gains, states: int) -> Row:
    """Return the set torque as a row over the states."""
    row = [0.0] * states
    row[E], row[V], row[INTEGRAL] = gains.kp * gains.kv, -gains.kp, 1.0
    return row


def reach(step: Matrix, states: int, steps: int, row: Row) -> Row:
    """Return, per state, how far a unit of distance from the steady state moves `row` times the state in any step."""
    free = [line[:states] for line in step[:states]]
    power, most = identity(states), [0.0] * states
    for _ in range(steps + 1):
        now = product([row], power)[0]
        most = [max(a, abs(b)) for a, b in zip(most, now, strict=True)]
        power = product(free, power)
    return most
