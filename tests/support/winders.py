"""A roll of film and a dancer, as the tests of winders set them."""

from typing import Any, Final

FILM: Final[dict[str, Any]] = {
    "core_radius_m": 0.05,
    "initial_radius_m": 0.2,
    "core_inertia_kg_m2": 0.05,
    "thickness_m": 0.0001,
    "width_m": 0.5,
    "torque_nm_at_10_v": 50.0,
}
DANCER: Final = {"mass_kg": 4.0, "force_n": 200.0, "travel_m": 0.3, "damping_n_s_per_m": 60.0}
