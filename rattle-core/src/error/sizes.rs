//! Functions of another number of variables than the bodies between which they are: found when a program compiles, as
//! a constant that panics. Such a message is put together here, letter by letter, as formatting is not for constants.

/// Panics where a function of so many variables is none of so many bodies with so many coordinates, and of the time.
pub(crate) const fn expect_variables(variables: usize, bodies: usize, coordinates: usize, time: bool) {
    if variables == bodies * coordinates + time as usize {
        return;
    }
    let text = Text::new().many(bodies, " body of ", " bodies of ");
    let text = text.many(coordinates, " coordinate", " coordinates");
    let text = text.words(if bodies == 1 { " has " } else { " have " }).number(bodies * coordinates);
    let text = if time { text.words(", and the time is one more: ") } else { text.words(": ") };
    let text = text.words("expected a constraint or potential of ");
    let text = text.many(bodies * coordinates + time as usize, " variable", " variables");
    let text = text.words(", found one of ").number(variables);
    let text = text
        .words("; `rattle::links` are for points in space, `rattle::links::planar` for points in the plane");
    panic!("{}", text.as_str())
}

struct Text {
    bytes: [u8; 320],
    length: usize,
}

impl Text {
    const fn new() -> Self {
        Text { bytes: [0; 320], length: 0 }
    }

    const fn words(mut self, words: &str) -> Self {
        let mut i = 0;
        while i < words.len() {
            self = self.byte(words.as_bytes()[i]);
            i += 1;
        }
        self
    }

    const fn number(self, number: usize) -> Self {
        let rest = if number > 9 { self.number(number / 10) } else { self };
        rest.byte(b'0' + (number % 10) as u8)
    }

    const fn many(self, number: usize, one: &str, more: &str) -> Self {
        self.number(number).words(if number == 1 { one } else { more })
    }

    const fn byte(mut self, byte: u8) -> Self {
        if self.length < self.bytes.len() {
            self.bytes[self.length] = byte;
            self.length += 1;
        }
        self
    }

    const fn as_str(&self) -> &str {
        match str::from_utf8(self.bytes.split_at(self.length).0) {
            Ok(text) => text,
            Err(_) => "a function of another number of variables than the bodies have coordinates",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::expect_variables;
    use std::panic::catch_unwind;

    #[test]
    fn messages_name_both_sizes() {
        for (bodies, coordinates, time) in [(2, 3, false), (1, 2, true), (3, 2, false), (0, 3, false)] {
            expect_variables(bodies * coordinates + usize::from(time), bodies, coordinates, time);
        }
        let message_of = |variables, bodies, coordinates, time| {
            let panic = catch_unwind(|| expect_variables(variables, bodies, coordinates, time));
            let panic = panic.expect_err("refused");
            panic.downcast::<String>().map(|text| *text).expect("a text")
        };
        let message = |variables, time| message_of(variables, 2, 10, time);
        let space =
            "; `rattle::links` are for points in space, `rattle::links::planar` for points in the plane";
        let plain = "2 bodies of 10 coordinates have 20: expected a constraint or potential of 20 variables, \
                     found one of 6";
        assert_eq!(message(6, false), format!("{plain}{space}"));
        let moving = "2 bodies of 10 coordinates have 20, and the time is one more: \
                      expected a constraint or potential of 21 variables, found one of 20";
        assert_eq!(message(20, true), format!("{moving}{space}"));
        let one =
            "1 body of 1 coordinate has 1: expected a constraint or potential of 1 variable, found one of 6";
        assert_eq!(message_of(6, 1, 1, false), format!("{one}{space}"));
    }
}
