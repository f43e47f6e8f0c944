//! Bounding boxes in trees: influence pairs with exclusion sets, and a triangle BVH
