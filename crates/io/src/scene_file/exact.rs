//! Lists of a fixed length, checked at both ends: serde's own arrays take the first elements of a longer list of TOML without a word.

use std::{fmt, marker::PhantomData};

use serde::{
    Deserialize, Deserializer,
    de::{Error, IgnoredAny, SeqAccess, Visitor},
};

/// Reads a field with lists of a fixed length in it: `#[serde(deserialize_with = "exactly")]`.
pub(super) fn exactly<'de, T: Exact, D: Deserializer<'de>>(deserializer: D) -> Result<T, D::Error> {
    T::Read::deserialize(deserializer).map(T::of)
}

/// What is read as another type that checks its lengths.
pub(super) trait Exact {
    type Read: for<'de> Deserialize<'de>;

    fn of(read: Self::Read) -> Self;
}

impl Exact for f64 {
    type Read = Self;

    fn of(read: Self) -> Self {
        read
    }
}

impl Exact for String {
    type Read = Self;

    fn of(read: Self) -> Self {
        read
    }
}

impl<T: Exact, const N: usize> Exact for [T; N] {
    type Read = Row<T::Read, N>;

    fn of(Row(read): Self::Read) -> Self {
        read.map(T::of)
    }
}

impl<T: Exact> Exact for Vec<T> {
    type Read = Vec<T::Read>;

    fn of(read: Self::Read) -> Self {
        read.into_iter().map(T::of).collect()
    }
}

impl<T: Exact> Exact for Option<T> {
    type Read = Option<T::Read>;

    fn of(read: Self::Read) -> Self {
        read.map(T::of)
    }
}

/// A list of `N` elements and no more.
pub(super) struct Row<T, const N: usize>([T; N]);

impl<'de, T: Deserialize<'de>, const N: usize> Deserialize<'de> for Row<T, N> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_seq(Reader(PhantomData))
    }
}

struct Reader<T, const N: usize>(PhantomData<T>);

impl<'de, T: Deserialize<'de>, const N: usize> Visitor<'de> for Reader<T, N> {
    type Value = Row<T, N>;

    fn expecting(&self, text: &mut fmt::Formatter) -> fmt::Result {
        write!(text, "an array of length {N}")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Self::Value, A::Error> {
        let mut read = Vec::with_capacity(N);
        while let Some(element) = list.next_element()? {
            if read.len() == N {
                let mut length = N + 1;
                while list.next_element::<IgnoredAny>()?.is_some() {
                    length += 1;
                }
                return Err(A::Error::invalid_length(length, &self));
            }
            read.push(element);
        }
        read.try_into().map(Row).map_err(|read: Vec<T>| A::Error::invalid_length(read.len(), &self))
    }
}
