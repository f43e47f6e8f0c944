//! Modes 1 and 2, indices: triangles that share edges with recent ones, and sequences close to one of two others.

use super::{Reader, unzigzag};

/// Bytes after the codes of triangles: what the codes of two recent vertices mean.
const PAIRS: usize = 16;
/// Bytes after a sequence, without meaning.
const PADDING: usize = 4;

/// The last sixteen of something, the newest at 0.
struct Recent<T> {
    ring: [T; 16],
    pushed: usize,
}

impl<T: Copy + Default> Recent<T> {
    fn new() -> Self {
        Self { ring: [T::default(); 16], pushed: 0 }
    }

    fn push(&mut self, item: T) {
        self.ring[self.pushed % 16] = item;
        self.pushed += 1;
    }

    fn get(&self, age: u8) -> Result<T, String> {
        let place = self.pushed.checked_sub(usize::from(age) + 1);
        place.map(|place| self.ring[place % 16]).ok_or("its stream asks for what it has not given yet".to_owned())
    }
}

/// The state of a triangle stream.
struct Triangles<'a> {
    data: Reader<'a>,
    edges: Recent<[u32; 2]>,
    vertices: Recent<u32>,
    /// The first index that was never used.
    next: u32,
    /// The last index that was given by its difference.
    last: u32,
}

/// The indices of a triangle stream.
pub(super) fn triangles(stream: &[u8], count: usize) -> Result<Vec<u32>, String> {
    let (_, mut data, pairs) = Reader::open(stream, &[0xe1], PAIRS)?;
    if pairs[14..] != [0, 0] || pairs.iter().any(|pair| pair >> 4 == 15 || pair & 15 == 15) {
        return Err("its stream ends with a table that is not one of pairs".to_owned());
    }
    let codes = data.take(count / 3)?;
    let mut state = Triangles { data, edges: Recent::new(), vertices: Recent::new(), next: 0, last: 0 };
    let mut indices = Vec::with_capacity(count);
    for &code in codes {
        indices.extend(state.triangle(code, pairs)?);
    }
    state.data.close()?;
    Ok(indices)
}

impl Triangles<'_> {
    fn triangle(&mut self, code: u8, pairs: &[u8]) -> Result<[u32; 3], String> {
        match (code >> 4, code & 15) {
            (15, way) => self.apart(way, pairs),
            (edge, way) => self.beside(edge, way),
        }
    }

    /// A triangle beside a recent edge.
    fn beside(&mut self, edge: u8, way: u8) -> Result<[u32; 3], String> {
        let [a, b] = self.edges.get(edge)?;
        let c = match way {
            0 => self.unused(),
            1..=12 => self.vertices.get(way)?,
            13 => self.moved(u32::MAX),
            14 => self.moved(1),
            _ => self.given()?,
        };
        if !(1..=12).contains(&way) {
            self.vertices.push(c);
        }
        self.edges.push([c, b]);
        self.edges.push([a, c]);
        Ok([a, b, c])
    }

    /// A triangle with corners of its own: `way` names the pair in the table, or says that it follows.
    fn apart(&mut self, way: u8, pairs: &[u8]) -> Result<[u32; 3], String> {
        let is_explicit = way >= 14;
        let pair = if is_explicit { self.data.byte()? } else { pairs[usize::from(way)] };
        if is_explicit && pair == 0 {
            self.next = 0;
        }
        let a = if way == 15 { self.given()? } else { self.unused() };
        let (b, b_is_new) = self.corner(pair >> 4)?;
        let (c, c_is_new) = self.corner(pair & 15)?;
        self.vertices.push(a);
        for (corner, is_new) in [(b, b_is_new), (c, c_is_new)] {
            if is_new {
                self.vertices.push(corner);
            }
        }
        for edge in [[b, a], [c, b], [a, c]] {
            self.edges.push(edge);
        }
        Ok([a, b, c])
    }

    /// A corner by its code, and whether it counts as a new vertex.
    fn corner(&mut self, code: u8) -> Result<(u32, bool), String> {
        match code {
            0 => Ok((self.unused(), true)),
            15 => self.given().map(|corner| (corner, true)),
            _ => self.vertices.get(code - 1).map(|corner| (corner, false)),
        }
    }

    fn unused(&mut self) -> u32 {
        let index = self.next;
        self.next = index.wrapping_add(1);
        index
    }

    fn moved(&mut self, step: u32) -> u32 {
        self.last = self.last.wrapping_add(step);
        self.last
    }

    fn given(&mut self) -> Result<u32, String> {
        let step = unzigzag(self.data.varint()?);
        Ok(self.moved(step))
    }
}

/// The indices of a sequence.
pub(super) fn sequence(stream: &[u8], count: usize) -> Result<Vec<u32>, String> {
    let (_, mut data, _) = Reader::open(stream, &[0xd1], PADDING)?;
    if count > data.bytes.len() {
        return Err(super::ended());
    }
    let mut last = [0_u32; 2];
    let index = |_| {
        let code = data.varint()?;
        let last = &mut last[(code & 1) as usize];
        *last = last.wrapping_add(unzigzag(code >> 1));
        Ok(*last)
    };
    let indices = (0..count).map(index).collect::<Result<_, String>>()?;
    data.close()?;
    Ok(indices)
}
