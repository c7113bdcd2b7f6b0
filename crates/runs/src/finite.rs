//! Finds a number that is not finite in a value that was read from a file.
//!
//! The value is serialized into nothing; each number is visited with its place, such as
//! `runs[0].totals.energy_drift`. A checksum detects accidents only: a program that can write a
//! file can
//! write its checksum too.

use std::fmt::{self, Write as _};

use serde::{
    Serialize,
    ser::{
        Error, SerializeMap, SerializeSeq, SerializeStruct, SerializeStructVariant, SerializeTuple,
        SerializeTupleStruct, SerializeTupleVariant, Serializer,
    },
};
use thiserror::Error;

/// A number that is not finite.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("the number {place} must be finite, but is {value}")]
pub struct NotFinite {
    /// Its place in the value, by the names of fields and the indices of elements.
    pub place: String,
    /// NaN or an infinity.
    pub value: f64,
}

/// Verifies that all numbers of a value are finite.
///
/// # Errors
/// The first number that is not.
pub fn require_finite(value: &impl Serialize) -> Result<(), NotFinite> {
    let mut visitor = Visitor::default();
    match value.serialize(&mut visitor) {
        Err(Stop::NotFinite(value)) => Err(NotFinite {
            place: visitor.place(),
            value,
        }),
        // A value that cannot be serialized was not read from a file.
        Ok(()) | Err(Stop::Other) => Ok(()),
    }
}

/// Why the visit has ended before the last number.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Stop {
    NotFinite(f64),
    Other,
}

impl fmt::Display for Stop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self:?}")
    }
}

impl std::error::Error for Stop {}

impl Error for Stop {
    fn custom<T: fmt::Display>(_: T) -> Self {
        Self::Other
    }
}

/// A step from a value to one inside it.
#[derive(Debug, Clone, Copy)]
enum Step {
    Field(&'static str),
    Element(usize),
}

/// The place of the present number.
#[derive(Debug, Default)]
struct Visitor {
    path: Vec<Step>,
}

impl Visitor {
    /// Visits a value inside the present one. The path is kept where the visit ends.
    fn inside<T: Serialize + ?Sized>(&mut self, step: Step, value: &T) -> Result<(), Stop> {
        self.path.push(step);
        value.serialize(&mut *self)?;
        self.path.pop();
        Ok(())
    }

    fn place(&self) -> String {
        let mut place = String::new();
        for step in &self.path {
            let _ = match step {
                Step::Field(name) if place.is_empty() => write!(place, "{name}"),
                Step::Field(name) => write!(place, ".{name}"),
                Step::Element(index) => write!(place, "[{index}]"),
            };
        }
        place
    }
}

/// The parts of a value.
struct Inner<'a> {
    visitor: &'a mut Visitor,
    next: usize,
}

impl Inner<'_> {
    fn element<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Stop> {
        self.visitor.inside(Step::Element(self.next), value)?;
        self.next += 1;
        Ok(())
    }
}

/// Methods for values without numbers that could be infinite.
macro_rules! ignored {
    ($($name:ident: $type:ty),*) => { $(
        fn $name(self, _: $type) -> Result<(), Stop> {
            Ok(())
        }
    )* };
}

impl<'a> Serializer for &'a mut Visitor {
    type Ok = ();
    type Error = Stop;
    type SerializeSeq = Inner<'a>;
    type SerializeTuple = Inner<'a>;
    type SerializeTupleStruct = Inner<'a>;
    type SerializeTupleVariant = Inner<'a>;
    type SerializeMap = Inner<'a>;
    type SerializeStruct = Inner<'a>;
    type SerializeStructVariant = Inner<'a>;

    ignored!(
        serialize_bool: bool, serialize_i8: i8, serialize_i16: i16, serialize_i32: i32,
        serialize_i64: i64, serialize_i128: i128, serialize_u8: u8, serialize_u16: u16,
        serialize_u32: u32, serialize_u64: u64, serialize_u128: u128, serialize_char: char,
        serialize_str: &str, serialize_bytes: &[u8], serialize_unit_struct: &'static str
    );

    fn serialize_f32(self, value: f32) -> Result<(), Stop> {
        self.serialize_f64(f64::from(value))
    }

    fn serialize_f64(self, value: f64) -> Result<(), Stop> {
        if value.is_finite() {
            Ok(())
        } else {
            Err(Stop::NotFinite(value))
        }
    }

    fn serialize_none(self) -> Result<(), Stop> {
        Ok(())
    }

    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Result<(), Stop> {
        value.serialize(self)
    }

    fn serialize_unit(self) -> Result<(), Stop> {
        Ok(())
    }

    fn serialize_unit_variant(self, _: &'static str, _: u32, _: &'static str) -> Result<(), Stop> {
        Ok(())
    }

    fn serialize_newtype_struct<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        value: &T,
    ) -> Result<(), Stop> {
        value.serialize(self)
    }

    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        value: &T,
    ) -> Result<(), Stop> {
        self.inside(Step::Field(variant), value)
    }

    fn serialize_seq(self, _: Option<usize>) -> Result<Inner<'a>, Stop> {
        Ok(Inner {
            visitor: self,
            next: 0,
        })
    }

    fn serialize_tuple(self, _: usize) -> Result<Inner<'a>, Stop> {
        self.serialize_seq(None)
    }

    fn serialize_tuple_struct(self, _: &'static str, _: usize) -> Result<Inner<'a>, Stop> {
        self.serialize_seq(None)
    }

    fn serialize_tuple_variant(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        _: usize,
    ) -> Result<Inner<'a>, Stop> {
        self.serialize_seq(None)
    }

    fn serialize_map(self, _: Option<usize>) -> Result<Inner<'a>, Stop> {
        self.serialize_seq(None)
    }

    fn serialize_struct(self, _: &'static str, _: usize) -> Result<Inner<'a>, Stop> {
        self.serialize_seq(None)
    }

    fn serialize_struct_variant(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        _: usize,
    ) -> Result<Inner<'a>, Stop> {
        self.serialize_seq(None)
    }

    /// As in the files: a type may have another form in text.
    fn is_human_readable(&self) -> bool {
        false
    }
}

/// The traits of values with elements.
macro_rules! of_elements {
    ($($name:ident::$method:ident),*) => { $(
        impl $name for Inner<'_> {
            type Ok = ();
            type Error = Stop;

            fn $method<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Stop> {
                self.element(value)
            }

            fn end(self) -> Result<(), Stop> {
                Ok(())
            }
        }
    )* };
}
of_elements!(
    SerializeSeq::serialize_element,
    SerializeTuple::serialize_element,
    SerializeTupleStruct::serialize_field,
    SerializeTupleVariant::serialize_field
);

/// The traits of values with named fields.
macro_rules! of_fields {
    ($($name:ident),*) => { $(
        impl $name for Inner<'_> {
            type Ok = ();
            type Error = Stop;

            fn serialize_field<T: Serialize + ?Sized>(
                &mut self,
                name: &'static str,
                value: &T,
            ) -> Result<(), Stop> {
                self.visitor.inside(Step::Field(name), value)
            }

            fn end(self) -> Result<(), Stop> {
                Ok(())
            }
        }
    )* };
}
of_fields!(SerializeStruct, SerializeStructVariant);

impl SerializeMap for Inner<'_> {
    type Ok = ();
    type Error = Stop;

    fn serialize_key<T: Serialize + ?Sized>(&mut self, key: &T) -> Result<(), Stop> {
        self.visitor.inside(Step::Element(self.next), key)
    }

    fn serialize_value<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Stop> {
        self.element(value)
    }

    fn end(self) -> Result<(), Stop> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    #[derive(Serialize)]
    enum Kind {
        Plain,
        Pair(f64, f64),
        Named { x: Option<f32> },
    }

    #[derive(Serialize)]
    struct Value {
        name: String,
        kinds: Vec<Kind>,
        map: BTreeMap<u8, [f64; 2]>,
    }

    fn value() -> Value {
        let kinds = vec![
            Kind::Plain,
            Kind::Pair(1.0, -0.0),
            Kind::Named { x: Some(f32::MAX) },
        ];
        let map = BTreeMap::from([(1, [f64::MAX, f64::MIN_POSITIVE]), (7, [0.0; 2])]);
        Value {
            name: "NaN".to_owned(),
            kinds,
            map,
        }
    }

    #[test]
    fn a_number_that_is_not_finite_is_named_by_its_place() {
        assert_eq!(require_finite(&value()), Ok(()));
        let refused = |spoil: fn(&mut Value)| {
            let mut value = value();
            spoil(&mut value);
            require_finite(&value).unwrap_err().to_string()
        };
        assert_eq!(
            refused(|value| value.map.get_mut(&7).unwrap()[1] = f64::NAN),
            "the number map[1][1] must be finite, but is NaN"
        );
        let error = refused(|value| value.kinds[1] = Kind::Pair(0.0, f64::NEG_INFINITY));
        assert_eq!(error, "the number kinds[1][1] must be finite, but is -inf");
        let error = refused(|value| {
            value.kinds[2] = Kind::Named {
                x: Some(f32::INFINITY),
            }
        });
        assert_eq!(error, "the number kinds[2].x must be finite, but is inf");
    }
}
