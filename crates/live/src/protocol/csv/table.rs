//! The table of lines and their fields. Reading, writing and the documentation follow from it.

/// The content of a field, in the line and in the message.
#[derive(Debug, Clone, Copy)]
pub enum Kind {
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
pub struct Field {
    /// Its name in the documentation.
    pub name: &'static str,
    /// Its path in the message.
    pub path: &'static str,
    /// Its content.
    pub kind: Kind,
}

const fn field(name: &'static str, path: &'static str, kind: Kind) -> Field {
    Field { name, path, kind }
}

/// A kind of line.
#[derive(Debug, Clone, Copy)]
pub struct Form {
    /// The first field.
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
    field("t", "stamp", Kind::Stamp),
    field("robot", "robot", Kind::Text(8)),
];

/// Lines to the node.
pub const TO_NODE: &[Form] = &[
    Form {
        letter: "H",
        message: "hello",
        about: "who the peer is",
        fields: &[
            field("name", "name", Kind::Text(12)),
            field("role", "role", Kind::Choice(ROLES)),
            field("robots", "robots", Kind::Texts),
            field("token", "token", Kind::Text(40)),
        ],
    },
    Form {
        letter: "D",
        message: "detection",
        about: "the camera has seen an item",
        fields: &[
            field("t", "stamp", Kind::Stamp),
            field("x", "x", Kind::Milli),
            field("y", "y", Kind::Milli),
            field("id", "id", Kind::Text(12)),
            field("class", "class", Kind::Text(8)),
            field("area", "area_cm2", Kind::Number),
            field("weight", "weight", Kind::Number),
            field("angle", "angle", Kind::Degrees),
            field("height", "height", Kind::Milli),
        ],
    },
    Form {
        letter: "B",
        message: "belt",
        about: "how the belt moves",
        fields: &[
            field("t", "stamp", Kind::Stamp),
            field("speed", "speed", Kind::Milli),
            field("position", "position", Kind::Milli),
        ],
    },
    Form {
        letter: "R",
        message: "robot",
        about: "what a robot is doing",
        fields: &[
            field("t", "stamp", Kind::Stamp),
            field("robot", "name", Kind::Text(8)),
            field("state", "state", Kind::Choice(STATES)),
            field("free", "available_at", Kind::After),
            field("task", "task", Kind::Count),
        ],
    },
    Form {
        letter: "A",
        message: "ack",
        about: "the robot has understood the task and sets out",
        fields: &[
            field("t", "stamp", Kind::Stamp),
            field("task", "task", Kind::Count),
        ],
    },
    Form {
        letter: "F",
        message: "result",
        about: "the task is finished",
        fields: &[
            field("t", "stamp", Kind::Stamp),
            field("task", "task", Kind::Count),
            field("result", "result", Kind::Choice(RESULTS)),
            field("free", "available_at", Kind::After),
            field("found_x", "found/x", Kind::Milli),
            field("found_y", "found/y", Kind::Milli),
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
        fields: &[field("t", "stamp", Kind::Stamp)],
    },
];

/// Lines from the node. A message with two lines is written as both, in this order.
pub const FROM_NODE: &[Form] = &[
    Form {
        letter: "H",
        message: "hello",
        about: "whether the peer may stay, and why not",
        fields: &[
            field("accepted", "accepted", Kind::Flag),
            field("reason", "reason", Kind::Text(48)),
        ],
    },
    Form {
        letter: "I",
        message: "task",
        about: "which item the task that follows is about, and where it goes",
        fields: &[
            field("task", "id", Kind::Count),
            field("item", "item", Kind::Text(12)),
            field("class", "class", Kind::Text(8)),
            field("weight", "priority", Kind::Number),
            field("bin_x", "bin/x", Kind::Milli),
            field("bin_y", "bin/y", Kind::Milli),
            field("angle", "angle", Kind::Degrees),
            field("height", "height", Kind::Milli),
        ],
    },
    Form {
        letter: "T",
        message: "task",
        about: "pick the item",
        fields: &[
            field("t", "decided_at", Kind::Stamp),
            field("robot", "robot", Kind::Text(8)),
            field("task", "id", Kind::Count),
            field("revision", "revision", Kind::Count),
            field("start", "start", Kind::After),
            field("latest", "latest_start", Kind::After),
            field("meet", "meet_at", Kind::After),
            field("x", "meet/x", Kind::Milli),
            field("y", "meet/y", Kind::Milli),
        ],
    },
    Form {
        letter: "C",
        message: "cancel",
        about: "drop the task",
        fields: &[
            field("t", "stamp", Kind::Stamp),
            field("robot", "robot", Kind::Text(8)),
            field("task", "task", Kind::Count),
            field("reason", "reason", Kind::Text(32)),
        ],
    },
    Form {
        letter: "V",
        message: "belt_request",
        about: "the belt should move at this velocity",
        fields: &[
            field("t", "stamp", Kind::Stamp),
            field("speed", "speed", Kind::Milli),
            field("reason", "reason", Kind::Text(32)),
        ],
    },
    Form {
        letter: "S",
        message: "status",
        about: "figures",
        fields: &[
            field("t", "stamp", Kind::Stamp),
            field("seen", "seen", Kind::Count),
            field("picked", "picked", Kind::Count),
            field("missed", "missed", Kind::Sum),
            field("on_belt", "on_belt", Kind::Count),
            field("claimed", "claimed", Kind::Count),
            field("last", "last", Kind::Flag),
        ],
    },
    Form {
        letter: "U",
        message: "due",
        about: "everything up to the tick is decided; when the next decision is due",
        fields: &[
            field("t", "stamp", Kind::Stamp),
            field("next", "next", Kind::After),
        ],
    },
];
