#![doc = include_str!("../README.md")]

mod compile;
mod debug;
mod desc;
mod draw;
mod encode;
mod error;
mod graph;
mod handle;
mod kernel;
mod plan;
mod pool;
mod reasons;
mod reflect;
mod state;

pub mod layered {
    //! Places for boxes and wires, for programs that draw a graph of their own: as [`Snapshot::svg`](crate::Snapshot::svg)
    //! has them.

    pub use crate::draw::layers::{Item, Layout, Net, Route, layout};
}

pub use compile::{Edge, Hazard, PlanCounts};
pub use debug::{Capture, CaptureWhen, Debug, DebugError};
pub use desc::{
    First, FirstBuffer, FrameParams, HistoryBuffer, HistoryTexture, Load, Previous, Size,
    TextureDesc,
};
pub use draw::{NodeInfo, PassInfo, ResourceInfo, ResourceKind, Snapshot, UseInfo};
pub use encode::Resources;
pub use error::{Code, EncodeError, GraphError, GraphErrors, RepeatError, Site, Warning};
pub use graph::{ComputeNode, ForeignNode, FrameGraph, HistoryInfo, RasterNode, Repeat, Reset};
pub use handle::{Buffer, Label, Subresources, Texture, View};
pub use kernel::{ComputeKernel, KernelDesc, KernelError, RasterKernel, RasterKernelDesc};
pub use plan::{Plan, Step, StepKind, Transition};
pub use pool::{
    CaptureError, Captured, CapturedPart, ClassMemory, Memory, NodeTiming, PlanMemory, Pool,
    ResourceMemory, SlotMemory, TenantMemory,
};
pub use reasons::Reason;
pub use reflect::{
    Binding, BindingAccess, BindingKind, Member, MemberType, Reflection, Sample, Scalar,
    StructLayout, WgslError,
};
pub use state::{Mode, State};
