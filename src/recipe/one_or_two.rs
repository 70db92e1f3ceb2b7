//! Two values of a recipe for which one may stand: the same along x and y.

use std::fmt;
use std::marker::PhantomData;

use serde::de::value::Error as Unlike;
use serde::de::{Deserializer, Error, IntoDeserializer, SeqAccess, Unexpected, Visitor};
use serde::{Deserialize, Serialize, Serializer};

/// Reads them; `expected` says what would do, such as `a whole number, or two such as [5, 3]`.
pub(super) fn read<'de, D, T>(deserializer: D, expected: &'static str) -> Result<[T; 2], D::Error>
where
    D: Deserializer<'de>,
    T: Deserialize<'de> + Copy,
{
    struct OneOrTwo<T>(&'static str, PhantomData<T>);

    impl<T> OneOrTwo<T> {
        fn one<'a, E: Error>(
            &self,
            value: impl IntoDeserializer<'a, Unlike>,
            unlike: Unexpected<'_>,
        ) -> Result<[T; 2], E>
        where
            T: Deserialize<'a> + Copy,
        {
            let one = T::deserialize(value.into_deserializer());
            one.map(|one| [one; 2]).map_err(|_| E::invalid_value(unlike, &self.0))
        }
    }

    impl<'de, T: Deserialize<'de> + Copy> Visitor<'de> for OneOrTwo<T> {
        type Value = [T; 2];

        fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
            f.write_str(self.0)
        }

        fn visit_f64<E: Error>(self, both: f64) -> Result<[T; 2], E> {
            self.one(both, Unexpected::Float(both))
        }

        fn visit_u64<E: Error>(self, both: u64) -> Result<[T; 2], E> {
            self.one(both, Unexpected::Unsigned(both))
        }

        fn visit_i64<E: Error>(self, both: i64) -> Result<[T; 2], E> {
            self.one(both, Unexpected::Signed(both))
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut sequence: A) -> Result<[T; 2], A::Error> {
            let mut values = Vec::new();
            while let Some(value) = sequence.next_element::<T>()? {
                values.push(value);
            }
            values.try_into().map_err(|v: Vec<T>| A::Error::invalid_length(v.len(), &self))
        }
    }

    deserializer.deserialize_any(OneOrTwo(expected, PhantomData))
}

/// Writes them, one where both are the same.
pub(super) fn write<S: Serializer, T: Serialize + PartialEq>(both: &[T; 2], serializer: S) -> Result<S::Ok, S::Error> {
    if both[0] == both[1] { both[0].serialize(serializer) } else { both.serialize(serializer) }
}
