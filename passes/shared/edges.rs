//! Parameters of `passes/edges.wgsl`.

scumble::choice! {
    /// How depth keeps texels apart.
    pub enum DepthForm {
        /// By the depth difference over what the slope explains, as in the papers.
        #[default]
        Slope,
        /// By what the slope leaves unexplained: planes stay whole.
        Residual,
    }
}
