//! Written by `tests/data/random_expressions.py`.

use super::*;

constraint! { #[doc = "A row."] pub(super) struct Row0 { a } |x, y, z| x + y + z + a * ((((z - -(x * (pi * x))))^(1/2) - acosh(-(z + pi)))) }
constraint! { #[doc = "A row."] pub(super) struct Row1 { a } |x, y, z| x + y + z + a * ((max(((if z < ((x + 2) * (z + pi)) { ((y + 0.5) - (z + 0.5)) } else { (0.5 * y) }) * (y + pi)), (-(z + y))^7))^(3/2)) }
constraint! { #[doc = "A row."] pub(super) struct Row2 { a } |x, y, z| x + y + z + a * ((((-z + ((if z < z { x } else { a }))^7) + --(if y < x { x } else { a })) * a)) }
constraint! { #[doc = "A row."] pub(super) struct Row3 { a } |x, y, z| x + y + z + a * (((((((a + 0.5) / (x + 2)) + (y)^2))^6 * atan2(((y + z) / exp((x + 0.5))), (if (x + 2) < (z * x) { ((z + 0.5) * z) } else { (z + 0.5) }))) * ((((z + 2) - (y)^5) / -min((a + pi), x)))^-3)) }
constraint! { #[doc = "A row."] pub(super) struct Row4 { a } |x, y, z| x + y + z + a * ((x - -((((a + 2) + a))^(5/2) * -((a + pi))^3))) }
constraint! { #[doc = "A row."] pub(super) struct Row5 { a } |x, y, z| x + y + z + a * ((hypot(((-z + (z + (a + pi))) + (-y)^2), max(((if (z + 2) < (pi * z) { (z + pi) } else { a }))^(1/2), sinh((z + z)))))^(5/2)) }
constraint! { #[doc = "A row."] pub(super) struct Row6 { a } |x, y, z| x + y + z + a * (((atan2((((y + 2) * x) + sinh((pi * y))), (((2 * z) * (a + 0.5)))^(3/2)) - (hypot(atan2((z + 0.5), x), exp((pi * z))) + log2((if z < (x + 2) { x } else { x })))) * z)) }
constraint! { #[doc = "A row."] pub(super) struct Row7 { a } |x, y, z| x + y + z + a * (z) }
constraint! { #[doc = "A row."] pub(super) struct Row8 { a } |x, y, z| x + y + z + a * (sqrt((atanh(z) * (((a + (z + pi)) / ((z + 2))^2))^2))) }
constraint! { #[doc = "A row."] pub(super) struct Row9 { a } |x, y, z| x + y + z + a * ((x * max((y + 0.5), ((if y < exp((0.5 * z)) { ((z + 0.5))^(5/2) } else { x }) + atan((z + pi)))))) }
constraint! { #[doc = "A row."] pub(super) struct Row10 { a } |x, y, z| x + y + z + a * (y) }
constraint! { #[doc = "A row."] pub(super) struct Row11 { a } |x, y, z| x + y + z + a * (-((atan2(((pi * y) + x), (y * (z + 0.5))) + a) + ((sin(a) / (0.5 * a)) - ((if (pi * y) < (pi * z) { (0.5 * y) } else { (x + 2) }))^3))) }
constraint! { #[doc = "A row."] pub(super) struct Row12 { a } |x, y, z| x + y + z + a * (y) }
constraint! { #[doc = "A row."] pub(super) struct Row13 { a } |x, y, z| x + y + z + a * ((sin(((((2 * x) * z) - y))^(5/2)))^(3/2)) }
constraint! { #[doc = "A row."] pub(super) struct Row14 { a } |x, y, z| x + y + z + a * ((pi * z)) }
constraint! { #[doc = "A row."] pub(super) struct Row15 { a } |x, y, z| x + y + z + a * ((if x < asinh((((x + x) + ((x + 0.5) + y)) / (if z < -x { ((pi * z))^4 } else { (pi * z) }))) { ((x - (log10(a) * (if y < x { (pi * a) } else { (z + 0.5) }))) * (atan(-x) * atan2(((2 * x) + (z + pi)), sinh(a)))) } else { y })) }
constraint! { #[doc = "A row."] pub(super) struct Row16 { a } |x, y, z| x + y + z + a * ((((-(x * y) * ((z)^(1/2) + ((2 * x))^-3)) / a) - (atanh((sqrt(x) + max(a, z))) / x))) }
constraint! { #[doc = "A row."] pub(super) struct Row17 { a } |x, y, z| x + y + z + a * (atan2(-(((if (pi * y) < (0.5 * a) { x } else { (2 * y) }) + ((a + 2) * x)) * log2(asin(a))), -atan2((cos(y) + -(y + 2)), (x * atan(y))))) }
constraint! { #[doc = "A row."] pub(super) struct Row18 { a } |x, y, z| x + y + z + a * (((((x * (a + (0.5 * y))) + ((z + 2) * ((z + pi))^(5/2))))^-1)^(1/2)) }
constraint! { #[doc = "A row."] pub(super) struct Row19 { a } |x, y, z| x + y + z + a * (a) }
constraint! { #[doc = "A row."] pub(super) struct Row20 { a } |x, y, z| x + y + z + a * (((((acos(z))^-1)^(5/2) / log2(cos(((0.5 * y) + x)))) * max((max(((a + 2) - (0.5 * z)), -(y + 0.5)))^-2, abs((if (z + 0.5) < y { (a * (y + 2)) } else { z }))))) }
constraint! { #[doc = "A row."] pub(super) struct Row21 { a } |x, y, z| x + y + z + a * (cos(a)) }
constraint! { #[doc = "A row."] pub(super) struct Row22 { a } |x, y, z| x + y + z + a * (max(y, y)) }
constraint! { #[doc = "A row."] pub(super) struct Row23 { a } |x, y, z| x + y + z + a * (atan2(-(tan(-(pi * x)))^3, z)) }
constraint! { #[doc = "A row."] pub(super) struct Row24 { a } |x, y, z| x + y + z + a * ((y + 2)) }
constraint! { #[doc = "A row."] pub(super) struct Row25 { a } |x, y, z| x + y + z + a * (-(x + 2)) }
constraint! { #[doc = "A row."] pub(super) struct Row26 { a } |x, y, z| x + y + z + a * (((((((0.5 * a))^(5/2) / tan(z)) + -(x * (y + pi))))^4)^4) }
constraint! { #[doc = "A row."] pub(super) struct Row27 { a } |x, y, z| x + y + z + a * (((((a / (z + (2 * y))) * (a + (if (y + 2) < y { z } else { a }))) / ((if z < ((z + pi) + (a + pi)) { exp((0.5 * a)) } else { (0.5 * a) }) - (if a < y { a } else { a }))) * ((((x * (x + pi)) * (y - (0.5 * a))) - (((y + 2))^-1)^6))^(5/2))) }
constraint! { #[doc = "A row."] pub(super) struct Row28 { a } |x, y, z| x + y + z + a * ((-(((if (a + 0.5) < (y + 2) { (y + 2) } else { (pi * x) }) * ((x + 2) + (z + pi))) - min(acos(a), (a + (0.5 * y)))))^(5/2)) }
constraint! { #[doc = "A row."] pub(super) struct Row29 { a } |x, y, z| x + y + z + a * (((acosh(((a)^(5/2))^-2) / -atanh(((y + 0.5))^(3/2))))^(5/2)) }
constraint! { #[doc = "A row."] pub(super) struct Row30 { a } |x, y, z| x + y + z + a * (-(-((if (0.5 * y) < (y + pi) { (x + 0.5) } else { (a + 0.5) }) - sin((y + 0.5))))^(3/2)) }
constraint! { #[doc = "A row."] pub(super) struct Row31 { a } |x, y, z| x + y + z + a * ((((if (a + pi) < -(x + pi) { (0.5 * z) } else { (x * a) }) + log10(((z - (y + 2)))^-1)))^(1/2)) }
constraint! { #[doc = "A row."] pub(super) struct Row32 { a } |x, y, z| x + y + z + a * (min((if z < (if (y + pi) < min(atan((0.5 * y)), ((z + 2) * (y + pi))) { a } else { ((a + pi))^(3/2) }) { ((cbrt(a) - (y * z)) + min(-x, (if a < (pi * z) { (2 * x) } else { (2 * y) }))) } else { (atanh(z) * exp((2 * z))) }), (if z < -((x)^(5/2) * min((pi * x), (a + pi))) { (sinh(log10((x + pi))) * ((if y < (pi * y) { y } else { (2 * y) }) * (if (a + 0.5) < (y + 2) { (x + 0.5) } else { (a + 0.5) }))) } else { -(y / (0.5 * y)) }))) }
constraint! { #[doc = "A row."] pub(super) struct Row33 { a } |x, y, z| x + y + z + a * (((((atan2((y + 0.5), (2 * z)) * ((z + 2))^4) / (((0.5 * a) * (2 * y)) * z)) / -(((z + pi))^-2 + (a)^4)) * -(if a < (2 * y) { (((y + 2))^(1/2) / ((pi * y) + (2 * x))) } else { (x / x) }))) }
constraint! { #[doc = "A row."] pub(super) struct Row34 { a } |x, y, z| x + y + z + a * (((if (2 * y) < (if a < sqrt(max(a, (pi * a))) { (atan(y) * max((z + 0.5), (a + 0.5))) } else { ((2 * a) + (z + 2)) }) { ((if z < ((z + pi) + y) { (y)^-1 } else { a }) * max(((a + pi))^(5/2), -(y + 0.5))) } else { ((z)^2 / asinh((2 * x))) }) * (atan2(min(hypot(a, x), (y - (0.5 * z))), max((if (pi * y) < y { y } else { (2 * x) }), ((0.5 * a) * (x + 0.5)))))^(3/2))) }
constraint! { #[doc = "A row."] pub(super) struct Row35 { a } |x, y, z| x + y + z + a * ((hypot(-y, (y + pi)) + asinh(atan2((((pi * y))^6 - ((y + pi) * x)), ((a / (0.5 * z)) * (a - z)))))) }
constraint! { #[doc = "A row."] pub(super) struct Row36 { a } |x, y, z| x + y + z + a * ((if (z + 0.5) < (-((if z < (a + 0.5) { (y + 0.5) } else { a }))^4 - (((y - (0.5 * z)) / -y) + (if z < (pi * x) { -z } else { (pi * y) }))) { (max((x * hypot((2 * y), z)), ((x / y) / log10((pi * y)))))^(1/2) } else { (((x)^3 + (a + (pi * z))) / (((pi * y) + (x + pi)) * asinh(z))) })) }
constraint! { #[doc = "A row."] pub(super) struct Row37 { a } |x, y, z| x + y + z + a * ((asin(log10(atanh(((pi * x))^7))) + (y)^3)) }
constraint! { #[doc = "A row."] pub(super) struct Row38 { a } |x, y, z| x + y + z + a * (z) }
constraint! { #[doc = "A row."] pub(super) struct Row39 { a } |x, y, z| x + y + z + a * ((((((x + 2) * cosh((y + pi))) + -z) + -(0.5 * a)) * (z)^(5/2))) }
constraint! { #[doc = "A row."] pub(super) struct Row40 { a } |x, y, z| x + y + z + a * ((-(atan2(asin(a), ((a + pi))^(5/2)) / (if (z + 2) < (x + 2) { -(pi * a) } else { (z + 2) })) * ((max(((pi * z) + x), z) - (asin(y))^5) + (acos(((0.5 * z) + x)))^(3/2)))) }
constraint! { #[doc = "A row."] pub(super) struct Row41 { a } |x, y, z| x + y + z + a * (atan2(sqrt(min((-(x + 2) + ((a + 0.5))^3), ((z * (pi * x)))^(3/2))), (if a < abs(x) { z } else { -atan2(x, a) }))) }
constraint! { #[doc = "A row."] pub(super) struct Row42 { a } |x, y, z| x + y + z + a * (((acosh(acos(exp(x))))^(3/2) / ((max((a * x), asin(y)))^7 + log2(((pi * z))^3)))) }
constraint! { #[doc = "A row."] pub(super) struct Row43 { a } |x, y, z| x + y + z + a * ((atanh((if (2 * x) < ((a)^-1 + min(y, y)) { (if (2 * x) < ((x + pi) * (x + pi)) { z } else { x }) } else { ((x + 0.5))^-2 })) * (((((z + pi))^(3/2))^3 + (z + pi)) * (min(((z + 0.5))^(3/2), ((2 * y) + (a + 2))))^(5/2)))) }
constraint! { #[doc = "A row."] pub(super) struct Row44 { a } |x, y, z| x + y + z + a * (x) }
constraint! { #[doc = "A row."] pub(super) struct Row45 { a } |x, y, z| x + y + z + a * (min(-atan2(cos(y), exp(min(a, (z + 2)))), (z + asinh(((a * a) * cbrt(y)))))) }
constraint! { #[doc = "A row."] pub(super) struct Row46 { a } |x, y, z| x + y + z + a * ((pi * x)) }
constraint! { #[doc = "A row."] pub(super) struct Row47 { a } |x, y, z| x + y + z + a * (asin((((min(a, z) * ((pi * z) / (0.5 * a))) * tan((a)^-2)))^(3/2))) }
constraint! { #[doc = "A row."] pub(super) struct Row48 { a } |x, y, z| x + y + z + a * ((atan2((if y < ((y + (0.5 * y)) + atanh(a)) { -(y + 0.5) } else { ((x + 2) * x) }), a) / acosh(((atan2((x + 0.5), (x + 2)))^-1 / (if z < z { (if a < z { (pi * x) } else { (y + 2) }) } else { (x + 2) }))))) }
constraint! { #[doc = "A row."] pub(super) struct Row49 { a } |x, y, z| x + y + z + a * (((x)^2 - (((((0.5 * a))^(3/2) * atan2((a + 0.5), (x + pi))) * (-(0.5 * a) * (x / (2 * y)))) / (((a)^7 * (a - (2 * y))) - -((y + 0.5) + y))))) }
constraint! { #[doc = "A row."] pub(super) struct Row50 { a } |x, y, z| x + y + z + a * ((atan(((if z < ((pi * x))^(1/2) { ((pi * a))^5 } else { (z + pi) }) * (0.5 * z))) + (asin((sinh(a))^(3/2)))^(5/2))) }
constraint! { #[doc = "A row."] pub(super) struct Row51 { a } |x, y, z| x + y + z + a * (((2 * z) / (hypot(atanh((a / x)), (x)^7) - ((((a + 0.5) + (pi * z)))^-1 / (pi * y))))) }
constraint! { #[doc = "A row."] pub(super) struct Row52 { a } |x, y, z| x + y + z + a * ((((atan2((2 * a), max(x, y)) + (((pi * a) + (pi * x)) * (a / (0.5 * x)))) / (((y * (pi * y)) + ((0.5 * a))^6) / tan((a)^3))) * (max((((y + 0.5) + z))^(5/2), -atan2(y, y)) + acos(tan(((x + 2) + (a + 0.5))))))) }
constraint! { #[doc = "A row."] pub(super) struct Row53 { a } |x, y, z| x + y + z + a * ((min((((x)^-2)^(5/2))^(3/2), (hypot(((pi * a) * y), ((2 * x) - y)) + (if z < atan2(x, (0.5 * z)) { (if x < (2 * z) { x } else { (y + 2) }) } else { (pi * a) }))) / (y + abs(((z + x) * -z))))) }
constraint! { #[doc = "A row."] pub(super) struct Row54 { a } |x, y, z| x + y + z + a * ((abs(x))^-1) }
constraint! { #[doc = "A row."] pub(super) struct Row55 { a } |x, y, z| x + y + z + a * (((((if (pi * y) < (2 * y) { -(a + pi) } else { (0.5 * z) }) * (exp(y) * abs(x))) * x) + (max((if a < (y)^6 { (z + y) } else { (y + 2) }), (((z + pi) - x) * ((2 * z) + (0.5 * a)))) * ((-(y + 0.5) + (if a < (z + 0.5) { x } else { y })) - (-(2 * a) * (z - (z + 0.5))))))) }
constraint! { #[doc = "A row."] pub(super) struct Row56 { a } |x, y, z| x + y + z + a * (atan2((((if (x + pi) < acosh((x + 0.5)) { z } else { (pi * x) }) - (((pi * y) + a) + a)) + ((((x + 2) * x))^-3 * ((x / (z + 2)) / abs((y + pi))))), (if x < (pi * z) { log2((((z + 2) + (0.5 * y)) + log2(y))) } else { (sin(x))^(1/2) }))) }
constraint! { #[doc = "A row."] pub(super) struct Row57 { a } |x, y, z| x + y + z + a * (-((asin((z - a)) * atan2(exp(z), tanh(z))))^-1) }
constraint! { #[doc = "A row."] pub(super) struct Row58 { a } |x, y, z| x + y + z + a * ((((tan(y) * (((x + 2) / x) + (a - a))) - (pi * z)) + (hypot(log2((a / (z + 0.5))), (if a < (a - a) { min(y, (y + 0.5)) } else { a })) * max((((0.5 * x) + (y + pi)) - atan2(x, (a + 0.5))), -((0.5 * y) * x))))) }
constraint! { #[doc = "A row."] pub(super) struct Row59 { a } |x, y, z| x + y + z + a * (asinh((min(cos(((pi * y) + (2 * x))), ((y + 2) * min(z, (y + 2)))) * sin(hypot((x)^(3/2), ((x + 2) + (y + pi))))))) }

pub(super) fn check_all() -> usize {
    let mut agreed = 0;
    agreed += check("row 0", Row0 { a: A }, |x, y, z| { let a = A; x + y + z + a * ((half((z - (-(x * (PI * x)))), 0) - ((-(z + PI))).acosh())) });
    agreed += check("row 1", Row1 { a: A }, |x, y, z| { let a = A; x + y + z + a * (half(larger(((if z < ((x + 2.0) * (z + PI)) { ((y + 0.5) - (z + 0.5)) } else { (0.5 * y) }) * (y + PI)), power((-(z + y)), 7)), 1)) });
    agreed += check("row 2", Row2 { a: A }, |x, y, z| { let a = A; x + y + z + a * (((((-z) + power((if z < z { x } else { a }), 7)) + (-(-(if y < x { x } else { a })))) * a)) });
    agreed += check("row 3", Row3 { a: A }, |x, y, z| { let a = A; x + y + z + a * (((power((((a + 0.5) / (x + 2.0)) + power(y, 2)), 6) * (((y + z) / ((x + 0.5)).exp())).atan2((if (x + 2.0) < (z * x) { ((z + 0.5) * z) } else { (z + 0.5) }))) * power((((z + 2.0) - power(y, 5)) / (-smaller((a + PI), x))), -3))) });
    agreed += check("row 4", Row4 { a: A }, |x, y, z| { let a = A; x + y + z + a * ((x - (-(half(((a + 2.0) + a), 2) * (-power((a + PI), 3)))))) });
    agreed += check("row 5", Row5 { a: A }, |x, y, z| { let a = A; x + y + z + a * (half(((((-z) + (z + (a + PI))) + power((-y), 2))).hypot(larger(half((if (z + 2.0) < (PI * z) { (z + PI) } else { a }), 0), ((z + z)).sinh())), 2)) });
    agreed += check("row 6", Row6 { a: A }, |x, y, z| { let a = A; x + y + z + a * (((((((y + 2.0) * x) + ((PI * y)).sinh())).atan2(half(((2.0 * z) * (a + 0.5)), 1)) - ((((z + 0.5)).atan2(x)).hypot(((PI * z)).exp()) + ((if z < (x + 2.0) { x } else { x })).log2())) * z)) });
    agreed += check("row 7", Row7 { a: A }, |x, y, z| { let a = A; x + y + z + a * (z) });
    agreed += check("row 8", Row8 { a: A }, |x, y, z| { let a = A; x + y + z + a * ((((z).atanh() * power(((a + (z + PI)) / power((z + 2.0), 2)), 2))).sqrt()) });
    agreed += check("row 9", Row9 { a: A }, |x, y, z| { let a = A; x + y + z + a * ((x * larger((y + 0.5), ((if y < ((0.5 * z)).exp() { half((z + 0.5), 2) } else { x }) + ((z + PI)).atan())))) });
    agreed += check("row 10", Row10 { a: A }, |x, y, z| { let a = A; x + y + z + a * (y) });
    agreed += check("row 11", Row11 { a: A }, |x, y, z| { let a = A; x + y + z + a * ((-(((((PI * y) + x)).atan2((y * (z + 0.5))) + a) + (((a).sin() / (0.5 * a)) - power((if (PI * y) < (PI * z) { (0.5 * y) } else { (x + 2.0) }), 3))))) });
    agreed += check("row 12", Row12 { a: A }, |x, y, z| { let a = A; x + y + z + a * (y) });
    agreed += check("row 13", Row13 { a: A }, |x, y, z| { let a = A; x + y + z + a * (half((half((((2.0 * x) * z) - y), 2)).sin(), 1)) });
    agreed += check("row 14", Row14 { a: A }, |x, y, z| { let a = A; x + y + z + a * ((PI * z)) });
    agreed += check("row 15", Row15 { a: A }, |x, y, z| { let a = A; x + y + z + a * ((if x < ((((x + x) + ((x + 0.5) + y)) / (if z < (-x) { power((PI * z), 4) } else { (PI * z) }))).asinh() { ((x - ((a).log10() * (if y < x { (PI * a) } else { (z + 0.5) }))) * (((-x)).atan() * (((2.0 * x) + (z + PI))).atan2((a).sinh()))) } else { y })) });
    agreed += check("row 16", Row16 { a: A }, |x, y, z| { let a = A; x + y + z + a * (((((-(x * y)) * (half(z, 0) + power((2.0 * x), -3))) / a) - ((((x).sqrt() + larger(a, z))).atanh() / x))) });
    agreed += check("row 17", Row17 { a: A }, |x, y, z| { let a = A; x + y + z + a * (((-(((if (PI * y) < (0.5 * a) { x } else { (2.0 * y) }) + ((a + 2.0) * x)) * ((a).asin()).log2()))).atan2((-(((y).cos() + (-(y + 2.0)))).atan2((x * (y).atan()))))) });
    agreed += check("row 18", Row18 { a: A }, |x, y, z| { let a = A; x + y + z + a * (half(power(((x * (a + (0.5 * y))) + ((z + 2.0) * half((z + PI), 2))), -1), 0)) });
    agreed += check("row 19", Row19 { a: A }, |x, y, z| { let a = A; x + y + z + a * (a) });
    agreed += check("row 20", Row20 { a: A }, |x, y, z| { let a = A; x + y + z + a * (((half(power((z).acos(), -1), 2) / ((((0.5 * y) + x)).cos()).log2()) * larger(power(larger(((a + 2.0) - (0.5 * z)), (-(y + 0.5))), -2), ((if (z + 0.5) < y { (a * (y + 2.0)) } else { z })).abs()))) });
    agreed += check("row 21", Row21 { a: A }, |x, y, z| { let a = A; x + y + z + a * ((a).cos()) });
    agreed += check("row 22", Row22 { a: A }, |x, y, z| { let a = A; x + y + z + a * (larger(y, y)) });
    agreed += check("row 23", Row23 { a: A }, |x, y, z| { let a = A; x + y + z + a * (((-power(((-(PI * x))).tan(), 3))).atan2(z)) });
    agreed += check("row 24", Row24 { a: A }, |x, y, z| { let a = A; x + y + z + a * ((y + 2.0)) });
    agreed += check("row 25", Row25 { a: A }, |x, y, z| { let a = A; x + y + z + a * ((-(x + 2.0))) });
    agreed += check("row 26", Row26 { a: A }, |x, y, z| { let a = A; x + y + z + a * (power(power(((half((0.5 * a), 2) / (z).tan()) + (-(x * (y + PI)))), 4), 4)) });
    agreed += check("row 27", Row27 { a: A }, |x, y, z| { let a = A; x + y + z + a * (((((a / (z + (2.0 * y))) * (a + (if (y + 2.0) < y { z } else { a }))) / ((if z < ((z + PI) + (a + PI)) { ((0.5 * a)).exp() } else { (0.5 * a) }) - (if a < y { a } else { a }))) * half((((x * (x + PI)) * (y - (0.5 * a))) - power(power((y + 2.0), -1), 6)), 2))) });
    agreed += check("row 28", Row28 { a: A }, |x, y, z| { let a = A; x + y + z + a * (half((-(((if (a + 0.5) < (y + 2.0) { (y + 2.0) } else { (PI * x) }) * ((x + 2.0) + (z + PI))) - smaller((a).acos(), (a + (0.5 * y))))), 2)) });
    agreed += check("row 29", Row29 { a: A }, |x, y, z| { let a = A; x + y + z + a * (half(((power(half(a, 2), -2)).acosh() / (-(half((y + 0.5), 1)).atanh())), 2)) });
    agreed += check("row 30", Row30 { a: A }, |x, y, z| { let a = A; x + y + z + a * ((-half((-((if (0.5 * y) < (y + PI) { (x + 0.5) } else { (a + 0.5) }) - ((y + 0.5)).sin())), 1))) });
    agreed += check("row 31", Row31 { a: A }, |x, y, z| { let a = A; x + y + z + a * (half(((if (a + PI) < (-(x + PI)) { (0.5 * z) } else { (x * a) }) + (power((z - (y + 2.0)), -1)).log10()), 0)) });
    agreed += check("row 32", Row32 { a: A }, |x, y, z| { let a = A; x + y + z + a * (smaller((if z < (if (y + PI) < smaller(((0.5 * y)).atan(), ((z + 2.0) * (y + PI))) { a } else { half((a + PI), 1) }) { (((a).cbrt() - (y * z)) + smaller((-x), (if a < (PI * z) { (2.0 * x) } else { (2.0 * y) }))) } else { ((z).atanh() * ((2.0 * z)).exp()) }), (if z < (-(half(x, 2) * smaller((PI * x), (a + PI)))) { ((((x + PI)).log10()).sinh() * ((if y < (PI * y) { y } else { (2.0 * y) }) * (if (a + 0.5) < (y + 2.0) { (x + 0.5) } else { (a + 0.5) }))) } else { (-(y / (0.5 * y))) }))) });
    agreed += check("row 33", Row33 { a: A }, |x, y, z| { let a = A; x + y + z + a * (((((((y + 0.5)).atan2((2.0 * z)) * power((z + 2.0), 4)) / (((0.5 * a) * (2.0 * y)) * z)) / (-(power((z + PI), -2) + power(a, 4)))) * (-(if a < (2.0 * y) { (half((y + 2.0), 0) / ((PI * y) + (2.0 * x))) } else { (x / x) })))) });
    agreed += check("row 34", Row34 { a: A }, |x, y, z| { let a = A; x + y + z + a * (((if (2.0 * y) < (if a < (larger(a, (PI * a))).sqrt() { ((y).atan() * larger((z + 0.5), (a + 0.5))) } else { ((2.0 * a) + (z + 2.0)) }) { ((if z < ((z + PI) + y) { power(y, -1) } else { a }) * larger(half((a + PI), 2), (-(y + 0.5)))) } else { (power(z, 2) / ((2.0 * x)).asinh()) }) * half((smaller((a).hypot(x), (y - (0.5 * z)))).atan2(larger((if (PI * y) < y { y } else { (2.0 * x) }), ((0.5 * a) * (x + 0.5)))), 1))) });
    agreed += check("row 35", Row35 { a: A }, |x, y, z| { let a = A; x + y + z + a * ((((-y)).hypot((y + PI)) + (((power((PI * y), 6) - ((y + PI) * x))).atan2(((a / (0.5 * z)) * (a - z)))).asinh())) });
    agreed += check("row 36", Row36 { a: A }, |x, y, z| { let a = A; x + y + z + a * ((if (z + 0.5) < ((-power((if z < (a + 0.5) { (y + 0.5) } else { a }), 4)) - (((y - (0.5 * z)) / (-y)) + (if z < (PI * x) { (-z) } else { (PI * y) }))) { half(larger((x * ((2.0 * y)).hypot(z)), ((x / y) / ((PI * y)).log10())), 0) } else { ((power(x, 3) + (a + (PI * z))) / (((PI * y) + (x + PI)) * (z).asinh())) })) });
    agreed += check("row 37", Row37 { a: A }, |x, y, z| { let a = A; x + y + z + a * (((((power((PI * x), 7)).atanh()).log10()).asin() + power(y, 3))) });
    agreed += check("row 38", Row38 { a: A }, |x, y, z| { let a = A; x + y + z + a * (z) });
    agreed += check("row 39", Row39 { a: A }, |x, y, z| { let a = A; x + y + z + a * ((((((x + 2.0) * ((y + PI)).cosh()) + (-z)) + (-(0.5 * a))) * half(z, 2))) });
    agreed += check("row 40", Row40 { a: A }, |x, y, z| { let a = A; x + y + z + a * (((-(((a).asin()).atan2(half((a + PI), 2)) / (if (z + 2.0) < (x + 2.0) { (-(PI * a)) } else { (z + 2.0) }))) * ((larger(((PI * z) + x), z) - power((y).asin(), 5)) + half((((0.5 * z) + x)).acos(), 1)))) });
    agreed += check("row 41", Row41 { a: A }, |x, y, z| { let a = A; x + y + z + a * (((smaller(((-(x + 2.0)) + power((a + 0.5), 3)), half((z * (PI * x)), 1))).sqrt()).atan2((if a < (x).abs() { z } else { (-(x).atan2(a)) }))) });
    agreed += check("row 42", Row42 { a: A }, |x, y, z| { let a = A; x + y + z + a * ((half((((x).exp()).acos()).acosh(), 1) / (power(larger((a * x), (y).asin()), 7) + (power((PI * z), 3)).log2()))) });
    agreed += check("row 43", Row43 { a: A }, |x, y, z| { let a = A; x + y + z + a * ((((if (2.0 * x) < (power(a, -1) + smaller(y, y)) { (if (2.0 * x) < ((x + PI) * (x + PI)) { z } else { x }) } else { power((x + 0.5), -2) })).atanh() * ((power(half((z + PI), 1), 3) + (z + PI)) * half(smaller(half((z + 0.5), 1), ((2.0 * y) + (a + 2.0))), 2)))) });
    agreed += check("row 44", Row44 { a: A }, |x, y, z| { let a = A; x + y + z + a * (x) });
    agreed += check("row 45", Row45 { a: A }, |x, y, z| { let a = A; x + y + z + a * (smaller((-((y).cos()).atan2((smaller(a, (z + 2.0))).exp())), (z + (((a * a) * (y).cbrt())).asinh()))) });
    agreed += check("row 46", Row46 { a: A }, |x, y, z| { let a = A; x + y + z + a * ((PI * x)) });
    agreed += check("row 47", Row47 { a: A }, |x, y, z| { let a = A; x + y + z + a * ((half(((smaller(a, z) * ((PI * z) / (0.5 * a))) * (power(a, -2)).tan()), 1)).asin()) });
    agreed += check("row 48", Row48 { a: A }, |x, y, z| { let a = A; x + y + z + a * ((((if y < ((y + (0.5 * y)) + (a).atanh()) { (-(y + 0.5)) } else { ((x + 2.0) * x) })).atan2(a) / ((power(((x + 0.5)).atan2((x + 2.0)), -1) / (if z < z { (if a < z { (PI * x) } else { (y + 2.0) }) } else { (x + 2.0) }))).acosh())) });
    agreed += check("row 49", Row49 { a: A }, |x, y, z| { let a = A; x + y + z + a * ((power(x, 2) - (((half((0.5 * a), 1) * ((a + 0.5)).atan2((x + PI))) * ((-(0.5 * a)) * (x / (2.0 * y)))) / ((power(a, 7) * (a - (2.0 * y))) - (-((y + 0.5) + y)))))) });
    agreed += check("row 50", Row50 { a: A }, |x, y, z| { let a = A; x + y + z + a * (((((if z < half((PI * x), 0) { power((PI * a), 5) } else { (z + PI) }) * (0.5 * z))).atan() + half((half((a).sinh(), 1)).asin(), 2))) });
    agreed += check("row 51", Row51 { a: A }, |x, y, z| { let a = A; x + y + z + a * (((2.0 * z) / ((((a / x)).atanh()).hypot(power(x, 7)) - (power(((a + 0.5) + (PI * z)), -1) / (PI * y))))) });
    agreed += check("row 52", Row52 { a: A }, |x, y, z| { let a = A; x + y + z + a * ((((((2.0 * a)).atan2(larger(x, y)) + (((PI * a) + (PI * x)) * (a / (0.5 * x)))) / (((y * (PI * y)) + power((0.5 * a), 6)) / (power(a, 3)).tan())) * (larger(half(((y + 0.5) + z), 2), (-(y).atan2(y))) + ((((x + 2.0) + (a + 0.5))).tan()).acos()))) });
    agreed += check("row 53", Row53 { a: A }, |x, y, z| { let a = A; x + y + z + a * ((smaller(half(half(power(x, -2), 2), 1), ((((PI * a) * y)).hypot(((2.0 * x) - y)) + (if z < (x).atan2((0.5 * z)) { (if x < (2.0 * z) { x } else { (y + 2.0) }) } else { (PI * a) }))) / (y + (((z + x) * (-z))).abs()))) });
    agreed += check("row 54", Row54 { a: A }, |x, y, z| { let a = A; x + y + z + a * (power((x).abs(), -1)) });
    agreed += check("row 55", Row55 { a: A }, |x, y, z| { let a = A; x + y + z + a * (((((if (PI * y) < (2.0 * y) { (-(a + PI)) } else { (0.5 * z) }) * ((y).exp() * (x).abs())) * x) + (larger((if a < power(y, 6) { (z + y) } else { (y + 2.0) }), (((z + PI) - x) * ((2.0 * z) + (0.5 * a)))) * (((-(y + 0.5)) + (if a < (z + 0.5) { x } else { y })) - ((-(2.0 * a)) * (z - (z + 0.5))))))) });
    agreed += check("row 56", Row56 { a: A }, |x, y, z| { let a = A; x + y + z + a * (((((if (x + PI) < ((x + 0.5)).acosh() { z } else { (PI * x) }) - (((PI * y) + a) + a)) + (power(((x + 2.0) * x), -3) * ((x / (z + 2.0)) / ((y + PI)).abs())))).atan2((if x < (PI * z) { ((((z + 2.0) + (0.5 * y)) + (y).log2())).log2() } else { half((x).sin(), 0) }))) });
    agreed += check("row 57", Row57 { a: A }, |x, y, z| { let a = A; x + y + z + a * ((-power((((z - a)).asin() * ((z).exp()).atan2((z).tanh())), -1))) });
    agreed += check("row 58", Row58 { a: A }, |x, y, z| { let a = A; x + y + z + a * (((((y).tan() * (((x + 2.0) / x) + (a - a))) - (PI * z)) + ((((a / (z + 0.5))).log2()).hypot((if a < (a - a) { smaller(y, (y + 0.5)) } else { a })) * larger((((0.5 * x) + (y + PI)) - (x).atan2((a + 0.5))), (-((0.5 * y) * x)))))) });
    agreed += check("row 59", Row59 { a: A }, |x, y, z| { let a = A; x + y + z + a * (((smaller((((PI * y) + (2.0 * x))).cos(), ((y + 2.0) * smaller(z, (y + 2.0)))) * ((half(x, 1)).hypot(((x + 2.0) + (y + PI)))).sin())).asinh()) });
    agreed
}
