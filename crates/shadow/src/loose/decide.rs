//! The points that the filter leaves in doubt.
//!
//! What is named in doubt is all that may hide the point or any other of its slack box, or meet the box: only that is asked exactly. If none of it meets the
//! box, which f64 tells nearly always, the point lies in space. A point of a flat face that is turned to the light has no box.

use glam::DVec3;
use umbriel_geometry::{
    LightSource, Sign, accept_point,
    blocking::Probe,
    predicates::{Target, side_filter},
};

use crate::{
    bodies::Body,
    exact::Own,
    fine::flat::flat_probe,
    loose::{Points, filter::Doubtful, on_faces::LitScene, pieces::Pieces},
    query::{Among, Place, Queries},
    receivers::flat_corners,
    slack::SlackBox,
};

impl LitScene<'_> {
    /// The answers for the doubtful of some points.
    pub(super) fn decide_all(self, points: Points, doubtful: Vec<Doubtful>, lit: &mut [bool]) {
        for doubt in doubtful {
            let index = doubt.index as usize;
            lit[index] = self.queries.decide(self.pieces, &points.place(index), &doubt, self.light);
        }
    }
}

impl Queries<'_> {
    /// The answer for a doubtful point.
    fn decide(&self, pieces: &Pieces, place: &Place, doubt: &Doubtful, light: &LightSource) -> bool {
        let Some(faces) = &doubt.faces else { return self.ask(place, light) };
        let faces: Vec<(usize, usize)> = faces.iter().map(|&first| pieces.face(first)).collect();
        let among = Among::Faces(&faces);
        let blocks = |probe: &Probe, own| self.is_blocked(probe, own, light, among);
        match *place {
            Place::Free { position } => !blocks(&Probe::at(accepted(position)), Own::Nothing),
            Place::Oriented { position, normal, precision } => {
                let (position, normal) = (accepted(position), DVec3::from_array(normal));
                let slack = SlackBox::new(position, precision);
                if faces.iter().any(|&face| self.may_touch(face, &slack)) {
                    return self.oriented_is_lit(position, normal, &slack, light, among).lit;
                }
                !blocks(&Probe::at(position), Own::Nothing)
            }
            Place::Surface { object, face, u, v } => match self.bodies.get(object) {
                // What it touches may be left out.
                Body::Flat(_) if pieces.turned(object).is_some_and(|turned| turned.is_entered) => {
                    self.ask(place, light)
                }
                Body::Flat(facets) => {
                    !blocks(&flat_probe(&flat_corners(facets, face, 0), u, v), Own::Face { object, face })
                }
                Body::Analytic(_) => self.ask(place, light),
            },
        }
    }

    /// Whether a point with a normal has no surface in its slack box.
    pub(super) fn is_in_space(&self, place: &Place) -> bool {
        let Place::Oriented { position, precision, .. } = *place else { return false };
        let slack = SlackBox::new(accepted(position), precision);
        let mut is_touched = false;
        self.objects.for_each_meeting(&slack.bounds, |object| {
            let object = object as usize;
            match self.bodies.get(object) {
                Body::Analytic(body) => is_touched = is_touched || slack.point_on_analytic(body, None).is_some(),
                Body::Flat(facets) => self.face_tree(object, facets).for_each_meeting(&slack.bounds, |face| {
                    let face = face as usize;
                    is_touched = is_touched
                        || self.may_touch((object, face), &slack) && slack.point_on_face(facets, face).is_some();
                }),
            }
        });
        !is_touched
    }

    /// False when the face certainly has no point in the slack box.
    fn may_touch(&self, (object, face): (usize, usize), slack: &SlackBox) -> bool {
        match self.bodies.get(object) {
            Body::Analytic(_) => self.bodies.bounds(object).meets(&slack.bounds),
            Body::Flat(facets) => {
                let corners = facets.facet(face).corners();
                let [a, b, c] = [corners[0], corners[1], corners[corners.len() - 1]].map(|corner| facets.point(corner));
                let side = side_filter(&a, &b, &c, Target::Point(&slack.whole()));
                side.sign().is_none_or(|sign| sign == Sign::Zero) && facets.facet_bounds(face).meets(&slack.bounds)
            }
        }
    }
}

/// The coordinates with one zero; they were checked.
fn accepted(position: [f64; 3]) -> DVec3 {
    accept_point(position).unwrap_or_default()
}
