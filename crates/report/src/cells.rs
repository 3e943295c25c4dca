//! The fields of a row: a struct, or a tuple or list of structs, as named cells.

use serde::ser::{
    Error as _, Impossible, Serialize, SerializeSeq, SerializeStruct, SerializeTuple, Serializer,
};
use std::fmt;

/// One value of a table.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Cell {
    Empty,
    Flag(bool),
    Count(u64),
    Number(f64),
    Text(String),
}

impl fmt::Display for Cell {
    /// As a field of a CSV file. Numbers have all their digits, but neither an exponent nor a `.0`:
    /// `5`, `0.000001`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => Ok(()),
            Self::Flag(flag) => flag.fmt(f),
            Self::Count(count) => count.fmt(f),
            Self::Number(number) => number.fmt(f),
            Self::Text(text) => f.write_str(text),
        }
    }
}

/// A field's name with its value.
pub(crate) type NamedCell = (&'static str, Cell);

/// The cells of `row`.
pub(crate) fn cells(row: &impl Serialize) -> Vec<NamedCell> {
    let mut cells = RowCells::default();
    // The rows of this crate have only fields that become cells, which the tests of every report see.
    let _ = row.serialize(&mut cells);
    cells.found
}

#[derive(Default)]
struct RowCells {
    found: Vec<NamedCell>,
    /// The name of the field that is serialised.
    field: &'static str,
}

impl RowCells {
    fn push(&mut self, cell: Cell) -> Result<(), NoCell> {
        self.found.push((self.field, cell));
        Ok(())
    }
}

/// A value that is no cell.
#[derive(Debug)]
struct NoCell(String);

impl fmt::Display for NoCell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for NoCell {}

impl serde::ser::Error for NoCell {
    fn custom<T: fmt::Display>(problem: T) -> Self {
        Self(problem.to_string())
    }
}

/// Methods of a serializer that make a cell of a value.
macro_rules! cells_of {
    ($($method:ident($kind:ty) => $cell:expr;)*) => {
        $(fn $method(self, value: $kind) -> Result<(), NoCell> {
            let cell: fn($kind) -> Result<Cell, NoCell> = $cell;
            self.push(cell(value)?)
        })*
    };
}

fn whole(value: i64) -> Result<Cell, NoCell> {
    let negative = |_| NoCell::custom("a negative count");
    u64::try_from(value).map(Cell::Count).map_err(negative)
}

impl Serializer for &mut RowCells {
    type Ok = ();
    type Error = NoCell;
    type SerializeSeq = Self;
    type SerializeTuple = Self;
    type SerializeStruct = Self;
    type SerializeTupleStruct = Impossible<(), NoCell>;
    type SerializeTupleVariant = Impossible<(), NoCell>;
    type SerializeMap = Impossible<(), NoCell>;
    type SerializeStructVariant = Impossible<(), NoCell>;

    cells_of! {
        serialize_bool(bool) => |value| Ok(Cell::Flag(value));
        serialize_i8(i8) => |value| whole(value.into());
        serialize_i16(i16) => |value| whole(value.into());
        serialize_i32(i32) => |value| whole(value.into());
        serialize_i64(i64) => whole;
        serialize_u8(u8) => |value| Ok(Cell::Count(value.into()));
        serialize_u16(u16) => |value| Ok(Cell::Count(value.into()));
        serialize_u32(u32) => |value| Ok(Cell::Count(value.into()));
        serialize_u64(u64) => |value| Ok(Cell::Count(value));
        serialize_f32(f32) => |value| Ok(Cell::Number(value.into()));
        serialize_f64(f64) => |value| Ok(Cell::Number(value));
        serialize_char(char) => |value| Ok(Cell::Text(value.into()));
        serialize_str(&str) => |value| Ok(Cell::Text(value.to_owned()));
        serialize_bytes(&[u8]) => |_| Err(NoCell::custom("bytes"));
        serialize_unit_struct(&'static str) => |_| Ok(Cell::Empty);
    }

    fn serialize_none(self) -> Result<(), NoCell> {
        self.push(Cell::Empty)
    }

    fn serialize_some<T: ?Sized + Serialize>(self, value: &T) -> Result<(), NoCell> {
        value.serialize(self)
    }

    fn serialize_unit(self) -> Result<(), NoCell> {
        self.push(Cell::Empty)
    }

    fn serialize_unit_variant(
        self,
        _: &'static str,
        _: u32,
        name: &'static str,
    ) -> Result<(), NoCell> {
        self.push(Cell::Text(name.to_owned()))
    }

    fn serialize_newtype_struct<T: ?Sized + Serialize>(
        self,
        _: &'static str,
        value: &T,
    ) -> Result<(), NoCell> {
        value.serialize(self)
    }

    fn serialize_newtype_variant<T: ?Sized + Serialize>(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        _: &T,
    ) -> Result<(), NoCell> {
        Err(NoCell::custom("a variant with a value"))
    }

    fn serialize_seq(self, _: Option<usize>) -> Result<Self, NoCell> {
        Ok(self)
    }

    fn serialize_tuple(self, _: usize) -> Result<Self, NoCell> {
        Ok(self)
    }

    fn serialize_struct(self, _: &'static str, _: usize) -> Result<Self, NoCell> {
        Ok(self)
    }

    fn serialize_tuple_struct(
        self,
        _: &'static str,
        _: usize,
    ) -> Result<Self::SerializeTupleStruct, NoCell> {
        Err(NoCell::custom("a tuple struct"))
    }

    fn serialize_tuple_variant(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        _: usize,
    ) -> Result<Self::SerializeTupleVariant, NoCell> {
        Err(NoCell::custom("a variant with values"))
    }

    fn serialize_map(self, _: Option<usize>) -> Result<Self::SerializeMap, NoCell> {
        Err(NoCell::custom("a map"))
    }

    fn serialize_struct_variant(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        _: usize,
    ) -> Result<Self::SerializeStructVariant, NoCell> {
        Err(NoCell::custom("a variant with fields"))
    }
}

impl SerializeSeq for &mut RowCells {
    type Ok = ();
    type Error = NoCell;

    fn serialize_element<T: ?Sized + Serialize>(&mut self, value: &T) -> Result<(), NoCell> {
        value.serialize(&mut **self)
    }

    fn end(self) -> Result<(), NoCell> {
        Ok(())
    }
}

impl SerializeTuple for &mut RowCells {
    type Ok = ();
    type Error = NoCell;

    fn serialize_element<T: ?Sized + Serialize>(&mut self, value: &T) -> Result<(), NoCell> {
        value.serialize(&mut **self)
    }

    fn end(self) -> Result<(), NoCell> {
        Ok(())
    }
}

impl SerializeStruct for &mut RowCells {
    type Ok = ();
    type Error = NoCell;

    fn serialize_field<T: ?Sized + Serialize>(
        &mut self,
        field: &'static str,
        value: &T,
    ) -> Result<(), NoCell> {
        self.field = field;
        value.serialize(&mut **self)
    }

    fn end(self) -> Result<(), NoCell> {
        Ok(())
    }
}
