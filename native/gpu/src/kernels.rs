// SPDX-License-Identifier: GPL-3.0-or-later
//! The kernels: their WGSL, what they bind, and their CPU twins.

/// Threads of a group of the kernels that go over vertices.
pub const GROUP: usize = 256;

/// Bytes of workgroup memory that a kernel needs at most; every adapter has them (WebGPU's own minimum).
const WORKGROUP_BYTES: usize = 16384;

macro_rules! resources {
    ($($(#[$about:meta])+ $variant:ident = $name:literal),+ $(,)?) => {
        /// A buffer that kernels bind, by its name in WGSL.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum Resource { $($(#[$about])+ $variant),+ }

        impl Resource {
            /// All of them.
            pub const ALL: &[Self] = &[$(Self::$variant),+];

            /// Name of the variable in the WGSL.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$variant => $name),+ }
            }
        }
    };
}

resources! {
    /// [`crate::types::Frame`], anew each frame.
    Frame = "frame",
    /// [`crate::types::Index`], one for each turn.
    Index = "index",
    /// [`crate::types::Tile`]s of at most [`GROUP`] slots.
    Tiles = "tiles",
    /// [`crate::types::Tile`]s for the coefficients.
    Runs = "runs",
    /// Steps of the basis recurrence of every cell.
    Knots = "knots",
    /// Parameters in the cell, and influence, of every slot.
    Places = "places",
    /// Coordinates of the slots as bound: all x, all y, all z.
    Rest = "rest",
    /// Displacement of the control points, and their mobility, anew each frame.
    Controls = "controls",
    /// Coordinates of the slots: all x, all y, all z.
    State = "state",
    /// Start of every block's steps.
    Offsets = "offsets",
    /// Closed walks of neighbours.
    Steps = "steps",
    /// Six times the gradient of the volume at every slot.
    Pull = "pull",
    /// Six times each group's share of the volume, as two-floats.
    Volumes = "volumes",
    /// Coefficients of each run for its taps.
    Partials = "partials",
    /// Start of every control point's entries.
    Starts = "starts",
    /// Indices into the partials.
    Entries = "entries",
    /// Six times the paper's coefficients, as two-floats.
    Coefficients = "coefficients",
    /// Step of the control points in each turn.
    Delta = "delta",
    /// [`crate::types::Status`] of each turn.
    Status = "status",
    /// Slot of every vertex.
    SlotOfVertex = "slot_of_vertex",
    /// How far every vertex moved.
    Moved = "moved",
}

const TYPES: &str = include_str!("../../../shaders/types.wgsl");
const TWO_FLOAT: &str = include_str!("../../../shaders/two_float.wgsl");
const BASIS: &str = include_str!("../../../shaders/basis.wgsl");

macro_rules! kernels {
    ($($(#[$about:meta])+ $variant:ident = $name:ident includes [$($include:ident),*] binds [$($resource:ident),+]),+ $(,)?) => {
        /// A kernel: `shaders/<name>.wgsl`, with its twin `twins::<name>::<name>`.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum Kernel { $($(#[$about])+ $variant),+ }

        impl Kernel {
            /// All of them, in the order of a frame.
            pub const ALL: &[Self] = &[$(Self::$variant),+];

            /// Name of the file, of the entry point and of the twin.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$variant => stringify!($name)),+ }
            }

            /// What it binds: entry `i` at binding `i` of group 0.
            pub const fn resources(self) -> &'static [Resource] {
                match self { $(Self::$variant => &[$(Resource::$resource),+]),+ }
            }

            /// Its WGSL for lattices with so many taps (degree + 1) along each axis.
            pub fn source(self, taps: [usize; 3]) -> String {
                let parts: &[&str] = match self {
                    $(Self::$variant => &[
                        $($include,)*
                        include_str!(concat!("../../../shaders/", stringify!($name), ".wgsl")),
                    ]),+
                };
                [&constants(taps), TYPES].into_iter().chain(parts.iter().copied()).collect()
            }
        }

        // A kernel without a twin of its name does not compile.
        const _: () = { $(let _ = crate::twins::$name::$name;)+ };
    };
}

kernels! {
    /// The deformation.
    Deform = deform includes [BASIS] binds [Frame, Tiles, Knots, Places, Rest, Controls, State],
    /// The gradient of the volume, and the volume.
    Gradient = gradient includes [TWO_FLOAT] binds [Frame, Index, Offsets, Steps, State, Pull, Volumes],
    /// Each run's share of the coefficients.
    Reduce = reduce includes [BASIS] binds [Runs, Knots, Places, Pull, Partials],
    /// The coefficients.
    Gather = gather includes [TWO_FLOAT] binds [Frame, Starts, Entries, Partials, Coefficients],
    /// The step of the control points.
    Solve = solve includes [TWO_FLOAT] binds [Frame, Index, Volumes, Coefficients, Controls, Delta, Status],
    /// The step of the vertices.
    Shift = shift includes [BASIS] binds [Frame, Index, Tiles, Knots, Places, Delta, State],
    /// The result in the order bound.
    Write = write includes [] binds [Frame, SlotOfVertex, Rest, State, Moved],
}

/// Whether a cell's control points fit in workgroup memory.
pub fn is_staged(taps: [usize; 3]) -> bool {
    taps.iter().product::<usize>() * size_of::<[f32; 4]>() <= WORKGROUP_BYTES / 2
}

fn constants(taps: [usize; 3]) -> String {
    let [u, v, w] = taps;
    format!(
        "const TAPS_U = {u}u;\nconst TAPS_V = {v}u;\nconst TAPS_W = {w}u;\nconst MAX_TAPS = {}u;\nconst TAPS = {}u;\nconst STAGED = {};\n",
        u.max(v).max(w),
        u * v * w,
        is_staged(taps)
    )
}
