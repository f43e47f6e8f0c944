//! Objects of a document whose members have names of any kind: attributes.

use std::{collections::BTreeMap, fmt, marker::PhantomData, ops::Deref};

use serde::{
    Deserialize, Deserializer,
    de::{Error, MapAccess, Visitor},
};

use crate::error::excerpt;

/// Members by their names. A name that is there twice is refused, as it is where names are known: glTF does not allow it,
/// and readers differ in which of the two they take.
#[derive(Debug)]
pub(in crate::gltf) struct Members<T>(BTreeMap<String, T>);

impl<T> Deref for Members<T> {
    type Target = BTreeMap<String, T>;

    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Members<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(Collector(PhantomData))
    }
}

struct Collector<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for Collector<T> {
    type Value = Members<T>;

    fn expecting(&self, text: &mut fmt::Formatter) -> fmt::Result {
        text.write_str("an object")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
        let mut members = BTreeMap::new();
        while let Some((name, value)) = map.next_entry::<String, T>()? {
            if members.contains_key(&name) {
                return Err(A::Error::custom(format_args!("duplicate field `{}`", excerpt(&name))));
            }
            members.insert(name, value);
        }
        Ok(Members(members))
    }
}
