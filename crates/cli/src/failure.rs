//! Why a verb stopped: one message.

/// Why a verb stopped.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    #[error(
        "no graphics adapter: neither Vulkan, Metal nor DirectX 12 offers one here; \
         Mesa's software Vulkan driver runs without a GPU (cargo xtask setup installs it)"
    )]
    NoAdapter,
    #[error(transparent)]
    Metrics(#[from] scumble_metrics::MetricsError),
    #[error("{option} takes one --metric to judge by, not {count}")]
    OneMetric { option: &'static str, count: usize },
    #[error("--fail-above is for errors; of {metric} a larger value is better: use --fail-below")]
    FailAboveSimilarity { metric: scumble_metrics::Metric },
    #[error(
        "--fail-below is for similarities; of {metric} a smaller value is better: use --fail-above"
    )]
    FailBelowError { metric: scumble_metrics::Metric },
}
