//! What the figures say, in words: what the curved surface gains over flat triangles, what it costs,
//! and where flat triangles are better.

use curvetri::compare::{Difference, Summary};
use serde::Serialize;

use super::figures::{Figures, FormFigures};
use super::measure::INTERPOLATED;
use super::table::number;

/// One thing to know.
#[derive(Debug, Serialize)]
pub struct Finding {
    /// Whom it speaks for.
    pub favours: Favours,
    pub text: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Favours {
    Curved,
    Flat,
    Neither,
}

/// Values that are as near as this to each other are said to be about the same.
const ALIKE: f64 = 1.05;

/// All that the figures say.
pub fn of(figures: &Figures) -> Vec<Finding> {
    let mut findings = match figures.reference() {
        Some(_) => errors(figures.flat(), figures.curved()),
        None => differences(figures.curved()),
    };
    findings.extend(interpolated(figures));
    findings.extend(terminator(figures));
    findings.extend(left_flat(figures.curved()));
    findings.push(time(figures));
    findings.push(setup(figures.curved()));
    findings.push(memory(figures));
    findings.extend(
        figures
            .reference()
            .map(|fine| price_of_fineness(figures, fine)),
    );
    findings
}

/// The shortest answer.
pub fn summary(figures: &Figures) -> String {
    let (flat, curved) = (figures.flat(), figures.curved());
    let cost = format!(
        "For {} times the rendering time and {} times the memory of flat triangles",
        number(curved.over_flat.render),
        number(curved.over_flat.bytes)
    );
    let outline = |difference: &Difference| difference.outline.map(|outline| outline.mean);
    let gain = match (&flat.difference, &curved.difference) {
        (Some(flat), Some(curved)) => {
            let flip = change(curved.flip, flat.flip);
            let outline = outline(curved).zip(outline(flat));
            let outline = outline.map(|(curved, flat)| change(curved, flat));
            let outline = outline.map_or(String::new(), |outline| {
                format!(" and the outline's {outline}")
            });
            format!("the error of the picture as the eye sees it is {flip}{outline}")
        }
        (None, Some(difference)) => {
            let outline = outline(difference).map_or(String::new(), |pixels| {
                format!(" and the outline by {} pixels on average", number(pixels))
            });
            format!(
                "the picture changes by {} as the eye sees it (FLIP, 0 to 1){outline}",
                number(difference.flip)
            )
        }
        _ => return cost + ".",
    };
    format!("{cost}, {gain}.")
}

/// How an error changes from flat triangles to the curved surface.
fn change(curved: f64, flat: f64) -> String {
    if curved == 0.0 && flat > 0.0 {
        "gone".into()
    } else if flat > ALIKE * curved {
        format!("{} times smaller", number(flat / curved))
    } else if flat == 0.0 && curved > 0.0 {
        "there, where it was none".into()
    } else if curved > ALIKE * flat {
        format!("{} times greater", number(curved / flat))
    } else {
        "about the same".into()
    }
}

/// How far either is from the reference.
fn errors(flat: &FormFigures, curved: &FormFigures) -> Vec<Finding> {
    let (Some(flat), Some(curved)) = (&flat.difference, &curved.difference) else {
        return Vec::new();
    };
    let mean = |spread: fn(&Difference) -> Option<Summary>| {
        [curved, flat].map(|difference| spread(difference).map(|spread| spread.mean))
    };
    let measures = [
        (
            "Picture, root mean square",
            " %",
            [curved, flat].map(|difference| Some(100.0 * difference.rmse)),
        ),
        (
            "Picture, as the eye sees it (FLIP, 0 to 1)",
            "",
            [curved, flat].map(|difference| Some(difference.flip)),
        ),
        (
            "Outline",
            " pixels on average",
            mean(|difference| difference.outline),
        ),
        (
            "Normals that it is lit by",
            " degrees on average",
            mean(|difference| difference.shading_normal),
        ),
        (
            "Normals of the geometry itself",
            " degrees on average",
            mean(|difference| difference.geometric_normal),
        ),
    ];
    let errors = measures.into_iter();
    errors
        .filter_map(|(what, unit, [curved, flat])| Some(nearer(what, unit, curved?, flat?)))
        .collect()
}

/// Whether the curved surface is nearer to the reference with its own normals or with interpolated ones.
fn interpolated(figures: &Figures) -> Option<Finding> {
    figures.reference()?;
    let mut forms = figures.forms.iter();
    let lit_by_vertices = forms.find(|form| form.name == INTERPOLATED)?;
    let [own, stored] = [figures.curved(), lit_by_vertices].map(|form| form.difference.as_ref());
    let (own, stored) = (own?, stored?);
    let nearer = if own.flip > ALIKE * stored.flip {
        "With interpolated normals the curved surface looks nearer to the reference"
    } else if stored.flip > ALIKE * own.flip {
        "With its own normals the curved surface looks nearer to the reference"
    } else {
        "The curved surface looks the same with its own normals and with interpolated ones"
    };
    let degrees = |difference: &Difference| {
        let normals = difference.shading_normal;
        normals.map_or("-".into(), |normals| number(normals.mean))
    };
    Some(Finding {
        favours: Favours::Neither,
        text: format!(
            "{nearer} (FLIP {} with its own, {} with interpolated ones; normals {} and {} degrees off on \
             average).",
            number(own.flip),
            number(stored.flip),
            degrees(own),
            degrees(stored)
        ),
    })
}

/// Which of two errors is the smaller, and how much.
fn nearer(what: &str, unit: &str, curved: f64, flat: f64) -> Finding {
    let smaller = |near: f64, far: f64| {
        if near > 0.0 {
            format!("{} times smaller for", number(far / near))
        } else {
            "nothing for".to_owned()
        }
    };
    let (favours, verdict) = if flat > ALIKE * curved {
        let smaller = smaller(curved, flat);
        (Favours::Curved, format!("{smaller} the curved surface"))
    } else if curved > ALIKE * flat {
        let smaller = smaller(flat, curved);
        (Favours::Flat, format!("{smaller} flat triangles"))
    } else {
        (Favours::Neither, "about the same".to_owned())
    };
    let [curved, flat] = [curved, flat].map(number);
    Finding {
        favours,
        text: format!("{what}: the error is {verdict} (curved {curved}, flat {flat}{unit})."),
    }
}

/// How far they are from each other, where nothing says which is right.
fn differences(curved: &FormFigures) -> Vec<Finding> {
    let Some(difference) = &curved.difference else {
        return Vec::new();
    };
    let mut text = format!(
        "The pictures differ by {} % (root mean square), as the eye sees it by {} (FLIP, 0 to 1)",
        number(100.0 * difference.rmse),
        number(difference.flip)
    );
    if let Some(outline) = difference.outline {
        text += &format!(
            ", the outlines by {} pixels on average and {} at the most",
            number(outline.mean),
            number(outline.max)
        );
    }
    text += ". Which is nearer to the true surface only a finer mesh of the same body can tell: --reference.";
    let mut texts = vec![text];
    texts.extend(difference.shading_normal.map(|normals| {
        format!(
            "The normals that they are lit by differ by {} degrees on average. Where a mesh is rough, the \
             curved surface shows bumps that interpolated normals hide.",
            number(normals.mean)
        )
    }));
    let texts = texts.into_iter();
    texts
        .map(|text| Finding {
            favours: Favours::Neither,
            text,
        })
        .collect()
}

fn terminator(figures: &Figures) -> Option<Finding> {
    let [flat, curved] = [figures.flat(), figures.curved()].map(|form| form.darkened);
    if flat.lit == 0 {
        return None;
    }
    let [f, c] = [flat, curved].map(|darkened| number(100.0 * darkened.share));
    let truth = match figures.reference() {
        Some(_) => format!("; the curved surface {c} %"),
        None => " on the curved surface".to_owned(),
    };
    let favours = match flat.darkened.cmp(&curved.darkened) {
        std::cmp::Ordering::Greater => Favours::Curved,
        std::cmp::Ordering::Less => Favours::Flat,
        std::cmp::Ordering::Equal => Favours::Neither,
    };
    Some(Finding {
        favours,
        text: format!(
            "Shadow terminator: flat triangles darken {f} % of the pixels where the sun shines{truth}."
        ),
    })
}

/// Triangles that the method leaves flat.
fn left_flat(curved: &FormFigures) -> Option<Finding> {
    let refused = ["flat_sliver", "flat_back_normal", "flat_bend", "flat_fold"];
    let refused: usize = refused.iter().map(|kind| curved.count(kind)).sum();
    let total = curved.count("total");
    (refused > 0).then(|| Finding {
        favours: Favours::Flat,
        text: format!(
            "{refused} of {total} triangles stay flat in the curved surface, because they are too thin, or bend too much for the method."
        ),
    })
}

fn time(figures: &Figures) -> Finding {
    let (flat, curved) = (figures.flat(), figures.curved());
    let over = &curved.over_flat;
    let runs = figures.picture.runs;
    let runs = if runs > 1 {
        format!(
            "; {} to {} times over {runs} runs",
            number(over.render_least),
            number(over.render_most)
        )
    } else {
        String::new()
    };
    Finding {
        favours: cheaper(over.render),
        text: format!(
            "Rendering the curved surface takes {} times as long as flat triangles ({} s against {} s{runs}).",
            number(over.render),
            number(curved.seconds.render),
            number(flat.seconds.render)
        ),
    }
}

fn setup(curved: &FormFigures) -> Finding {
    Finding {
        favours: cheaper(curved.over_flat.build),
        text: format!(
            "Setting it up (preparing the patches and building the tree) takes {} times as long: {} s.",
            number(curved.over_flat.build),
            number(curved.seconds.curve + curved.seconds.build)
        ),
    }
}

fn memory(figures: &Figures) -> Finding {
    let (flat, curved) = (figures.flat(), figures.curved());
    Finding {
        favours: cheaper(curved.over_flat.bytes),
        text: format!(
            "It takes {} times the memory: {} MB against {} MB.",
            number(curved.over_flat.bytes),
            number(curved.bytes.total as f64 * 1e-6),
            number(flat.bytes.total as f64 * 1e-6)
        ),
    }
}

/// Flat triangles can be good as well, if there are enough of them.
fn price_of_fineness(figures: &Figures, fine: &FormFigures) -> Finding {
    let curved = figures.curved();
    let ratio = |fine: f64, curved: f64| number(fine / curved);
    Finding {
        favours: Favours::Neither,
        text: format!(
            "The other way to a round look is more flat triangles: the reference has {} times as many, \
             and takes {} times the memory of the curved surface and {} times its time to render.",
            ratio(fine.count("total") as f64, curved.count("total") as f64),
            ratio(fine.bytes.total as f64, curved.bytes.total as f64),
            ratio(fine.seconds.render, curved.seconds.render)
        ),
    }
}

fn cheaper(over_flat: f64) -> Favours {
    if over_flat > ALIKE {
        Favours::Flat
    } else if over_flat * ALIKE < 1.0 {
        Favours::Curved
    } else {
        Favours::Neither
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whoever_is_nearer_is_said_to_be() {
        let of = |curved, flat| nearer("Outline", " pixels on average", curved, flat);
        let gain = of(0.1, 1.5);
        assert_eq!(gain.favours, Favours::Curved);
        assert_eq!(
            gain.text,
            "Outline: the error is 15 times smaller for the curved surface (curved 0.1, flat 1.5 \
             pixels on average)."
        );
        let loss = of(0.4, 0.2);
        assert_eq!(loss.favours, Favours::Flat);
        assert!(
            loss.text.contains("2 times smaller for flat triangles"),
            "{}",
            loss.text
        );
        assert_eq!(of(0.2, 0.201).favours, Favours::Neither);
        assert_eq!(of(0.0, 0.0).favours, Favours::Neither);
        assert!(of(0.0, 0.3).text.contains("nothing for the curved surface"));
    }

    #[test]
    fn errors_shrink_or_grow() {
        let changes = [
            (0.1, 0.4),
            (0.4, 0.1),
            (0.1, 0.1),
            (0.0, 0.1),
            (0.1, 0.0),
            (0.0, 0.0),
        ];
        let words = changes.map(|(curved, flat)| change(curved, flat));
        assert_eq!(
            words,
            [
                "4 times smaller",
                "4 times greater",
                "about the same",
                "gone",
                "there, where it was none",
                "about the same"
            ]
        );
    }

    #[test]
    fn what_costs_less_is_favoured() {
        assert_eq!(
            [3.0, 1.01, 0.5].map(cheaper),
            [Favours::Flat, Favours::Neither, Favours::Curved]
        );
    }
}
