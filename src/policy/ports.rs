//! The inputs of a network, and the observation's layout that they imply.

use super::check;
use crate::decision::observation::{Layout, View};
use crate::error::{Error, Result, shown};
use tract_onnx::pb::{GraphProto, tensor_proto::DataType};

/// The meaning of an input.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Input {
    /// In the type that the file specifies.
    Observation(Part, Real),
    Mask(MaskKind),
}

/// The part of the observation that an input takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Part {
    Whole,
    /// The part before the slots.
    Globals,
    Slots,
}

/// The precision of real numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Real {
    Single,
    Double,
}

/// The type in which an input takes the mask.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum MaskKind {
    Bool,
    Real(Real),
    Int64,
}

/// The network's inputs, and the layout that they imply.
pub(super) struct Ports {
    pub layout: Layout,
    /// All layouts that the sizes allow, the most likely first.
    pub layouts: Vec<Layout>,
    pub rows: usize,
    pub inputs: Vec<Port>,
}

pub(super) struct Port {
    pub kind: Input,
    pub width: usize,
}

impl Ports {
    /// The inputs of `graph`, with the layout in the metadata or, without one, with the layouts
    /// that the sizes allow; `place` is the file's name in messages.
    ///
    /// # Errors
    /// Inputs that are no observation and mask of this program.
    pub(super) fn find(graph: &GraphProto, told: Option<Layout>, place: &str) -> Result<Self> {
        let (mut inputs, rows) = read_inputs(graph, place)?;
        let widths = InputWidths::of(&inputs, place)?;
        let outputs = OutputWidths::of(graph);
        let layouts = match told {
            Some(layout) => vec![layout],
            None => layouts_of(widths.observation(), widths.mask, outputs.all()),
        };
        let Some(&layout) = layouts.first() else {
            return Err(no_layout(&widths, &outputs, place));
        };
        widths.check_against(&layout, place)?;
        split(&mut inputs, &widths.parts, &layout).map_err(|problem| {
            Error::input(
                place,
                problem,
                format!(
                    "export inputs of widths {} (globals) and {} (slots), or one of width {}",
                    layout.globals(),
                    layout.observation() - layout.globals(),
                    layout.observation()
                ),
            )
        })?;
        Ok(Self {
            layout,
            layouts,
            rows,
            inputs,
        })
    }
}

/// The inputs of `graph`, and the number of rows that they take at once.
fn read_inputs(graph: &GraphProto, place: &str) -> Result<(Vec<Port>, usize)> {
    let mut found = Vec::new();
    let mut rows = 1;
    for (index, value) in check::inputs(graph) {
        let name = shown(&value.name);
        let Some((dims, kind)) = check::shape(value) else {
            return Err(Error::input(
                place,
                format!("the input `{name}` is not a tensor of known shape"),
                "declare its shape [batch, numbers]",
            ));
        };
        let [batch, Some(width)] = dims[..] else {
            return Err(Error::input(
                place,
                format!("the input `{name}` has the shape {dims:?}"),
                "give it the shape [batch, numbers] with a fixed second size",
            ));
        };
        rows = batch.unwrap_or(rows);
        let Some(kind) = Input::of(&value.name, index, DataType::try_from(kind).ok()) else {
            return Err(Error::input(
                place,
                format!("the input `{name}` has an unsupported type"),
                "use f32 or f64 for observations and bool, f32, f64 or int64 for masks",
            ));
        };
        found.push(Port { kind, width });
    }
    Ok((found, rows))
}

impl Input {
    /// What the input `name`, the `index`-th of the network, is by its name and type; `None` if
    /// the type is not supported.
    fn of(name: &str, index: usize, kind: Option<DataType>) -> Option<Self> {
        let real = match kind {
            Some(DataType::Float) => Some(Real::Single),
            Some(DataType::Double) => Some(Real::Double),
            _ => None,
        };
        let is_mask = name.contains("mask") || (index > 0 && real.is_none());
        match (is_mask, real, kind) {
            (false, Some(real), _) => Some(Self::Observation(Part::Whole, real)),
            (true, Some(real), _) => Some(Self::Mask(MaskKind::Real(real))),
            (true, _, Some(DataType::Bool)) => Some(Self::Mask(MaskKind::Bool)),
            (true, _, Some(DataType::Int64)) => Some(Self::Mask(MaskKind::Int64)),
            _ => None,
        }
    }
}

/// The widths of the inputs.
struct InputWidths {
    /// Of the observation, or of its globals and slots in either order.
    parts: Vec<usize>,
    mask: Option<usize>,
}

impl InputWidths {
    fn of(inputs: &[Port], place: &str) -> Result<Self> {
        let widths = |mask: bool| -> Vec<usize> {
            let is_mask = |port: &&Port| matches!(port.kind, Input::Mask(_)) == mask;
            inputs
                .iter()
                .filter(is_mask)
                .map(|port| port.width)
                .collect()
        };
        let (parts, masks) = (widths(false), widths(true));
        let (1 | 2, mask @ ([] | [_])) = (parts.len(), &masks[..]) else {
            return Err(Error::input(
                place,
                format!(
                    "the network has {} inputs for observations and {} for masks",
                    parts.len(),
                    masks.len()
                ),
                "give one for the observation, or one for its globals and one for its slots, and \
                 at most one for the mask, named with `mask`",
            ));
        };
        let mask = mask.first().copied();
        Ok(Self { parts, mask })
    }

    fn observation(&self) -> usize {
        self.parts.iter().sum()
    }

    fn check_against(&self, layout: &Layout, place: &str) -> Result<()> {
        let expected = (layout.observation(), layout.actions());
        let found = (self.observation(), self.mask.unwrap_or(expected.1));
        if found == expected {
            return Ok(());
        }
        Err(Error::input(
            place,
            format!(
                "the network takes {} numbers and a mask of {}, but its metadata says {} and {}",
                found.0, found.1, expected.0, expected.1
            ),
            "export it again with `pickline train`",
        ))
    }
}

/// The widths of the outputs.
struct OutputWidths {
    fixed: Vec<usize>,
    /// Whether the exporter left another size dynamic.
    is_open: bool,
}

impl OutputWidths {
    fn of(graph: &GraphProto) -> Self {
        let widths = graph.output.iter().map(|value| {
            let (dims, _) = check::shape(value)?;
            *dims.last()?
        });
        Self {
            is_open: widths.clone().any(|width| width.is_none()),
            fixed: widths.flatten().collect(),
        }
    }

    /// The widths of all outputs; `None` if one is dynamic.
    fn all(&self) -> Option<&[usize]> {
        Some(&self.fixed[..]).filter(|_| !self.is_open)
    }
}

fn no_layout(inputs: &InputWidths, outputs: &OutputWidths, place: &str) -> Error {
    let views: Vec<String> = View::ALL.iter().copied().map(written).collect();
    Error::input(
        place,
        format!(
            "an input of {} numbers with outputs of {:?} matches no observation of this program",
            inputs.observation(),
            outputs.fixed
        ),
        format!(
            "train on one of: {}; outputs are the logits of K slots, and one more for waiting",
            views.join(", ")
        ),
    )
}

/// Determines which of two inputs, `parts` wide, takes which part of the observation, by their
/// widths.
fn split(ports: &mut [Port], parts: &[usize], layout: &Layout) -> std::result::Result<(), String> {
    let globals = layout.globals();
    let slots = layout.observation() - globals;
    if parts.len() == 1 {
        return Ok(());
    }
    if globals == slots || ![[globals, slots], [slots, globals]].contains(&[parts[0], parts[1]]) {
        return Err(format!(
            "its inputs of widths {} and {} cannot be matched to the parts of an observation",
            parts[0], parts[1]
        ));
    }
    for port in ports {
        if let Input::Observation(part, _) = &mut port.kind {
            *part = if port.width == globals {
                Part::Globals
            } else {
                Part::Slots
            };
        }
    }
    Ok(())
}

/// The size of a view's observation, for messages.
fn written(view: View) -> String {
    let layout = Layout {
        view,
        slots: 1,
        wait: false,
    };
    format!(
        "{view} ({} + {} K)",
        layout.globals(),
        layout.slot_features()
    )
}

/// The layouts with these sizes, if the file has no metadata; `outputs` is `None` if the file
/// leaves a size dynamic.
fn layouts_of(observation: usize, mask: Option<usize>, outputs: Option<&[usize]>) -> Vec<Layout> {
    let all = View::ALL.iter().flat_map(|view| {
        [false, true].map(|wait| Layout {
            view: *view,
            slots: 1,
            wait,
        })
    });
    let sized = all.filter_map(|layout| {
        let slots = observation.checked_sub(layout.globals())?;
        let per_slot = layout.slot_features();
        (slots % per_slot == 0 && (1..=Layout::MOST_SLOTS).contains(&(slots / per_slot))).then_some(
            Layout {
                slots: slots / per_slot,
                ..layout
            },
        )
    });
    let fitting = sized.filter(|layout| {
        let actions = layout.actions();
        mask.is_none_or(|mask| mask == actions)
            && outputs.is_none_or(|outputs| outputs.is_empty() || outputs.contains(&actions))
    });
    fitting.collect()
}
