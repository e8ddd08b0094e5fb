//! Bakes of one scene with settings changed: what each part of the method costs and brings.

/// The scene that is baked anew for each variant: small, with targets for all kinds of light.
pub(crate) const VARIED_SCENE: &str = "cornell";

/// One changed setting.
pub(crate) struct Variant {
    /// What it varies.
    pub(crate) part: &'static str,
    /// Options of `probelight bake`, none for the defaults.
    pub(crate) options: &'static str,
}

impl Variant {
    const fn new(part: &'static str, options: &'static str) -> Self {
        Self { part, options }
    }

    /// Its name among the figures' bakes.
    pub(crate) fn bake(&self) -> String {
        format!("{VARIED_SCENE} {}", self.options).trim_end().to_owned()
    }
}

/// Methods, metrics, precision and the error that is asked for.
pub(crate) const ACCURACY_AGAINST_BYTES: [Variant; 15] = [
    Variant::new("paper", "--method paper"),
    Variant::new("paper, 8 and 4 bits", "--method paper --storage packed"),
    Variant::new("plain metric, 16 bits", "--metric plain --storage f16"),
    Variant::new("plain metric", "--metric plain"),
    Variant::new("radiance metric, 16 bits", "--storage f16"),
    Variant::new("hybrid, defaults: radiance metric, 8 and 4 bits", ""),
    Variant::new("rank", "--max-rank 16"),
    Variant::new("rank", "--max-rank 64"),
    Variant::new("error", "--error .05"),
    Variant::new("error", "--error .02"),
    Variant::new("error", "--error .01"),
    Variant::new("error", "--error .005"),
    Variant::new("error", "--error .001"),
    Variant::new("error, plain metric", "--metric plain --error .05"),
    Variant::new("error, plain metric", "--metric plain --error .02"),
];

/// Each source of error by itself.
pub(crate) const ERROR_BUDGET: [Variant; 15] = [
    Variant::new("defaults", ""),
    Variant::new("ray noise", "--rays 4096"),
    Variant::new("texel interpolation", "--receivers 140000"),
    Variant::new("truncation and rounding", "--error .001"),
    Variant::new("choice of probes", "--probes-per-cluster 20"),
    Variant::new("probe spacing", "--probe-density 1.5"),
    Variant::new("probe sampling", "--relight-rays 512"),
    Variant::new("band limit", "--sh-degree 10"),
    Variant::new("probes taking over later", "--near-radius 4"),
    Variant::new("no probes at all", "--near-radius 1000 --error .01"),
    Variant::new("surfels", "--surfel-size .12"),
    Variant::new("light samples", "--samples-per-surfel 64"),
    Variant::new("smaller clusters", "--receivers-per-cluster 256"),
    Variant::new("larger clusters", "--receivers-per-cluster 1024"),
    Variant::new("blended borders", "--hard-borders"),
];

/// The options of all variants, each once.
pub(crate) fn all_options() -> Vec<&'static str> {
    let mut options = Vec::new();
    for variant in ACCURACY_AGAINST_BYTES.iter().chain(&ERROR_BUDGET) {
        if !options.contains(&variant.options) {
            options.push(variant.options);
        }
    }
    options
}
