// What a surfel reflects of one receiver's light.

struct Bounce {
    /// Sum of the samples' ρ/π, divided by the number of the surfel's samples.
    reflectance: vec3f,
    /// The receiver whose light is reflected, or NONE.
    receiver: u32,
}
