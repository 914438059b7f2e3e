// Objects whose keys are names of a rig.  They have only what was put into them: `constructor` may be a name, and an
// ordinary object has something of that name from the start.

// A new one with everything in others, of which later ones count.
export const named = (...others) => Object.assign(Object.create(null), ...others);

// Makes all objects of a JSON text such ones, as the second argument of JSON.parse.
export const asNamed = (_key, value) => (value !== null && typeof value === 'object' && !Array.isArray(value) ? Object.setPrototypeOf(value, null) : value);
