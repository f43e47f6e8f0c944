//! Tables and words, checked to be such: serde also takes a list of values for a struct, in the order of its fields, and a
//! table of one key for a word.

use std::{fmt, marker::PhantomData, ops::Deref};

use serde::{
    Deserialize, Deserializer,
    de::{
        Error, MapAccess, Visitor,
        value::{MapAccessDeserializer, StrDeserializer},
    },
};
use toml::Spanned;

/// A table and where in the file it stands.
pub(super) type Placed<T> = Spanned<Table<T>>;

/// A value that the file writes as a table.
#[derive(Clone, Copy, Debug)]
pub(super) struct Table<T>(T);

impl<T> Deref for Table<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.0
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Table<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(TableReader(PhantomData)).map(Self)
    }
}

struct TableReader<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for TableReader<T> {
    type Value = T;

    fn expecting(&self, text: &mut fmt::Formatter) -> fmt::Result {
        text.write_str("a table")
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<T, A::Error> {
        T::deserialize(MapAccessDeserializer::new(map))
    }
}

/// One word of a few, which the file writes as text.
#[derive(Clone, Copy, Debug)]
pub(super) struct Word<T>(pub(super) T);

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Word<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_str(WordReader(PhantomData)).map(Self)
    }
}

struct WordReader<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for WordReader<T> {
    type Value = T;

    fn expecting(&self, text: &mut fmt::Formatter) -> fmt::Result {
        text.write_str("a word in quotes")
    }

    fn visit_str<E: Error>(self, word: &str) -> Result<T, E> {
        T::deserialize(StrDeserializer::new(word))
    }
}
