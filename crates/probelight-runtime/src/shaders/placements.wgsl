// Where objects are.

// Rows of the matrix from the model's space to the world.
struct Placement {
    rows: array<vec4f, 3>,
    // Which of the objects it is.
    number: u32,
    // How far off its surface light in free space is read, metres.
    light_offset: f32,
    unused: array<u32, 2>,
}

fn placed_point(placement: Placement, point: vec3f) -> vec3f {
    let local = vec4f(point, 1.0);
    return vec3f(dot(placement.rows[0], local), dot(placement.rows[1], local), dot(placement.rows[2], local));
}

// Unit vector. Objects are scaled alike along all axes.
fn placed_direction(placement: Placement, direction: vec3f) -> vec3f {
    let local = vec4f(direction, 0.0);
    return normalize(
        vec3f(dot(placement.rows[0], local), dot(placement.rows[1], local), dot(placement.rows[2], local)),
    );
}
