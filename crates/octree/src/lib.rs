//! Morton codes and a pointerless, sorted octree
