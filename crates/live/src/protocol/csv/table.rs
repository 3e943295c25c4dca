//! The table of lines and their fields. Reading, writing and the documentation follow from it.

/// The content of a field, in the line and in the message.
#[derive(Debug, Clone, Copy)]
pub(super) enum FieldKind {
    /// A time [ms] modulo 10^9; a timestamp [s] in the message.
    Stamp,
    /// A time after the line's timestamp [ms]; a timestamp [s] in the message.
    After,
    /// [mm], to 0.1; [m] in the message. Also [mm/s] and [m/s].
    Milli,
    /// [deg], to 0.1; [rad] in the message.
    Degrees,
    /// A plain number.
    Number,
    /// An integer.
    Count,
    /// A text of at most this many characters; longer ones are truncated.
    Text(usize),
    /// One letter for each of these values.
    Choice(&'static [(&'static str, &'static str)]),
    /// 1 or 0.
    Flag,
    /// Texts separated by semicolons.
    Texts,
    /// The sum of an object's counts; write-only.
    Sum,
}

/// A field of a line.
#[derive(Debug, Clone, Copy)]
pub(super) struct Field {
    /// Its name in the documentation.
    pub name: &'static str,
    /// Its path in the message.
    pub path: &'static str,
    /// Its content.
    pub kind: FieldKind,
}

const fn field(name: &'static str, path: &'static str, kind: FieldKind) -> Field {
    Field { name, path, kind }
}

/// A kind of line.
#[derive(Debug, Clone, Copy)]
pub(super) struct Form {
    /// Its first field, by which the kind is told.
    pub letter: &'static str,
    /// The message's kind.
    pub message: &'static str,
    /// Its meaning.
    pub about: &'static str,
    /// The fields after letter and sequence number.
    pub fields: &'static [Field],
}

const STATES: &[(&str, &str)] = &[("I", "idle"), ("B", "busy"), ("F", "fault")];
const RESULTS: &[(&str, &str)] = &[
    ("P", "PICKED"),
    ("G", "GRASP_FAIL"),
    ("M", "MISSED"),
    ("R", "REJECTED"),
    ("C", "CANCELLED"),
];

const ROLES: &[(&str, &str)] = &[
    ("C", "camera"),
    ("E", "encoder"),
    ("R", "robot"),
    ("P", "operator"),
    ("O", "observer"),
];

const ORDER: &[Field] = &[
    field("t", "stamp", FieldKind::Stamp),
    field("robot", "robot", FieldKind::Text(8)),
];

/// Lines to the node.
pub(super) const TO_NODE: &[Form] = &[
    Form {
        letter: "H",
        message: "hello",
        about: "who the peer is",
        fields: &[
            field("name", "name", FieldKind::Text(12)),
            field("role", "role", FieldKind::Choice(ROLES)),
            field("robots", "robots", FieldKind::Texts),
            field("token", "token", FieldKind::Text(40)),
        ],
    },
    Form {
        letter: "D",
        message: "detection",
        about: "the camera has seen an item",
        fields: &[
            field("t", "stamp", FieldKind::Stamp),
            field("x", "x", FieldKind::Milli),
            field("y", "y", FieldKind::Milli),
            field("id", "id", FieldKind::Text(12)),
            field("class", "class", FieldKind::Text(8)),
            field("area", "area_cm2", FieldKind::Number),
            field("weight", "weight", FieldKind::Number),
            field("angle", "angle", FieldKind::Degrees),
            field("height", "height", FieldKind::Milli),
        ],
    },
    Form {
        letter: "B",
        message: "belt",
        about: "how the belt moves",
        fields: &[
            field("t", "stamp", FieldKind::Stamp),
            field("speed", "speed", FieldKind::Milli),
            field("position", "position", FieldKind::Milli),
        ],
    },
    Form {
        letter: "R",
        message: "robot",
        about: "what a robot is doing",
        fields: &[
            field("t", "stamp", FieldKind::Stamp),
            field("robot", "name", FieldKind::Text(8)),
            field("state", "state", FieldKind::Choice(STATES)),
            field("free", "available_at", FieldKind::After),
            field("task", "task", FieldKind::Count),
        ],
    },
    Form {
        letter: "A",
        message: "ack",
        about: "the robot has understood the task and sets out",
        fields: &[
            field("t", "stamp", FieldKind::Stamp),
            field("task", "task", FieldKind::Count),
        ],
    },
    Form {
        letter: "F",
        message: "result",
        about: "the task is finished",
        fields: &[
            field("t", "stamp", FieldKind::Stamp),
            field("task", "task", FieldKind::Count),
            field("result", "result", FieldKind::Choice(RESULTS)),
            field("free", "available_at", FieldKind::After),
            field("found_x", "found/x", FieldKind::Milli),
            field("found_y", "found/y", FieldKind::Milli),
        ],
    },
    Form {
        letter: "P",
        message: "pause",
        about: "pause: no new task; without a name for the whole line",
        fields: ORDER,
    },
    Form {
        letter: "G",
        message: "resume",
        about: "resume",
        fields: ORDER,
    },
    Form {
        letter: "E",
        message: "drain",
        about: "drain: known items are picked, later ones pass",
        fields: ORDER,
    },
    Form {
        letter: "X",
        message: "stop",
        about: "stop: no new task, and open ones are cancelled",
        fields: ORDER,
    },
    Form {
        letter: "K",
        message: "tick",
        about: "time has come this far",
        fields: &[field("t", "stamp", FieldKind::Stamp)],
    },
];

/// Lines from the node. A message with two lines is written as both, in this order.
pub(super) const FROM_NODE: &[Form] = &[
    Form {
        letter: "H",
        message: "hello",
        about: "whether the peer may stay, and why not",
        fields: &[
            field("accepted", "accepted", FieldKind::Flag),
            field("reason", "reason", FieldKind::Text(48)),
        ],
    },
    Form {
        letter: "I",
        message: "task",
        about: "which item the task that follows is about, and where it goes",
        fields: &[
            field("task", "id", FieldKind::Count),
            field("item", "item", FieldKind::Text(12)),
            field("class", "class", FieldKind::Text(8)),
            field("weight", "priority", FieldKind::Number),
            field("bin_x", "bin/x", FieldKind::Milli),
            field("bin_y", "bin/y", FieldKind::Milli),
            field("angle", "angle", FieldKind::Degrees),
            field("height", "height", FieldKind::Milli),
        ],
    },
    Form {
        letter: "T",
        message: "task",
        about: "pick the item",
        fields: &[
            field("t", "decided_at", FieldKind::Stamp),
            field("robot", "robot", FieldKind::Text(8)),
            field("task", "id", FieldKind::Count),
            field("revision", "revision", FieldKind::Count),
            field("start", "start", FieldKind::After),
            field("latest", "latest_start", FieldKind::After),
            field("meet", "meet_at", FieldKind::After),
            field("x", "meet/x", FieldKind::Milli),
            field("y", "meet/y", FieldKind::Milli),
        ],
    },
    Form {
        letter: "C",
        message: "cancel",
        about: "drop the task",
        fields: &[
            field("t", "stamp", FieldKind::Stamp),
            field("robot", "robot", FieldKind::Text(8)),
            field("task", "task", FieldKind::Count),
            field("reason", "reason", FieldKind::Text(32)),
        ],
    },
    Form {
        letter: "V",
        message: "belt_request",
        about: "the belt should move at this velocity",
        fields: &[
            field("t", "stamp", FieldKind::Stamp),
            field("speed", "speed", FieldKind::Milli),
            field("reason", "reason", FieldKind::Text(32)),
        ],
    },
    Form {
        letter: "S",
        message: "status",
        about: "figures",
        fields: &[
            field("t", "stamp", FieldKind::Stamp),
            field("seen", "seen", FieldKind::Count),
            field("picked", "picked", FieldKind::Count),
            field("missed", "missed", FieldKind::Sum),
            field("on_belt", "on_belt", FieldKind::Count),
            field("claimed", "claimed", FieldKind::Count),
            field("last", "last", FieldKind::Flag),
        ],
    },
    Form {
        letter: "L",
        message: "status",
        about: "how many of those seen are left on the belt on purpose; only on a line that leaves items",
        fields: &[
            field("t", "stamp", FieldKind::Stamp),
            field("unwanted", "unwanted", FieldKind::Count),
        ],
    },
    Form {
        letter: "U",
        message: "due",
        about: "everything up to the tick is decided; when the next decision is due",
        fields: &[
            field("t", "stamp", FieldKind::Stamp),
            field("next", "next", FieldKind::After),
        ],
    },
];
