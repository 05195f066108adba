//! The pictures that a comparison shows.

use curvetri::compare::{Difference, marked};
use image::RgbImage;

use super::Measurements;

/// A picture with its words.
pub struct Shown {
    /// Names it in links: lower-case letters and hyphens.
    pub key: String,
    /// A few words for a label.
    pub title: String,
    /// What is to be seen.
    pub caption: String,
    pub image: RgbImage,
}

/// All pictures of a comparison, and how much they differ.
pub struct Pictures {
    pub shown: Vec<Shown>,
    /// How far each form is from what it is judged by; nothing for that itself.
    pub difference: Vec<Option<Difference>>,
}

const SCALE: &str = "black where they look the same, over violet and orange to bright yellow";

impl Pictures {
    /// Compares everything with the reference or, without one, with the flat triangles.
    pub fn of(all: &Measurements) -> Self {
        let (flat, curved) = (all.flat(), all.curved());
        let mut shown: Vec<Shown> = all
            .all()
            .map(|form| Shown {
                key: form.contestant.name.clone(),
                title: form.contestant.name.clone(),
                caption: sentence(&form.contestant.title),
                image: form.view.image.clone(),
            })
            .collect();
        let between = curved.view.difference_from(&flat.view);
        shown.push(Shown {
            key: "difference".into(),
            title: "flat against curved".into(),
            caption: format!("How different flat and curved look (FLIP): {SCALE}."),
            image: between.flip_map.clone(),
        });
        let difference: Vec<Option<Difference>> = match &all.reference {
            None => {
                let others = all.forms[2..].iter();
                [None, Some(between)]
                    .into_iter()
                    .chain(others.map(|form| Some(form.view.difference_from(&flat.view))))
                    .collect()
            }
            Some(truth) => {
                let difference = all
                    .forms
                    .iter()
                    .map(|form| form.view.difference_from(&truth.view));
                difference.map(Some).chain([None]).collect()
            }
        };
        if all.reference.is_some() {
            for (form, difference) in all.forms.iter().zip(&difference) {
                let Some(difference) = difference else {
                    continue;
                };
                let name = &form.contestant.name;
                shown.push(Shown {
                    key: format!("{name}-error"),
                    title: format!("error of {name}"),
                    caption: format!(
                        "How different {name} and the reference look (FLIP): {SCALE}."
                    ),
                    image: difference.flip_map.clone(),
                });
            }
        }
        shown.push(Shown {
            key: "darkened".into(),
            title: "darkened by flat".into(),
            caption: "In red the pixels that flat triangles darken although the sun shines there: \
                      the shadow terminator."
                .into(),
            image: marked(&flat.view.image, &flat.view.probe, &all.truth().view.probe),
        });
        Self { shown, difference }
    }

    /// The picture of this key.
    pub fn get(&self, key: &str) -> Option<&Shown> {
        self.shown.iter().find(|shown| shown.key == key)
    }
}

/// Words with a capital letter in front and a full stop behind.
fn sentence(words: &str) -> String {
    let mut letters = words.chars();
    let first = letters.next().map(|c| c.to_uppercase().to_string());
    format!("{}{}.", first.unwrap_or_default(), letters.as_str())
}
