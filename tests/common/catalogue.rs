//! Every ready-made surface with its parameters: a name, the constraint, and a point on it where one is known.

/// The results of a function of each, in an array.
macro_rules! catalogue {
    ($check:ident) => {
        [
            $check("Sphere", Sphere { r: 1.5 }, Some([0.0, 0.0, 1.5])),
            $check("Ellipsoid", Ellipsoid { a: 1.0, b: 1.5, c: 0.5 }, Some([0.0, 1.5, 0.0])),
            $check("Cylinder", Cylinder { r: 1.5 }, Some([1.5, 0.0, 7.0])),
            $check("DentedCylinder", DentedCylinder { r: 1.0, l: 0.5, a: 0.25 }, Some([0.75, 0.0, 0.0])),
            $check("Plane", Plane { a: 1.0, b: 2.0, c: 2.0, d: 3.0 }, Some([3.0, 0.0, 0.0])),
            $check("WigglyPlane", WigglyPlane { a: 0.5, w: 2.0 }, Some([0.0, 3.0, 0.0])),
            $check(
                "GaussianBump",
                GaussianBump { a: 0.5, l: 0.5, inner: 1.0, outer: 1.5 },
                Some([0.0, 0.0, 0.5]),
            ),
            $check("Dumbbell", Dumbbell { a: 1.0, k: 1.2, b: 1.0, c: 2.0 }, Some([1.0, 0.0, 0.0])),
            $check("Spine", Spine { a: 1.0, k: 1.2, b: 1.0, b2: 0.5, c: 2.0 }, Some([1.0, 0.0, 0.0])),
            $check("SpineTwo", SpineTwo { a: 1.0, k: 1.2, b: 1.0, b2: 0.5, c: 2.0 }, Some([1.0, 0.0, 0.0])),
            $check("Thylakoid", Thylakoid { width: 1.0, length: 1.0, flare: 0.5 }, Some([0.0, 0.5, 0.0])),
            $check("Supersphere", Supersphere { r: 1.0, q: 4.0 }, Some([0.0, 0.0, 1.0])),
            $check(
                "Superellipsoid",
                Superellipsoid { a: 1.0, b: 1.5, c: 0.5, n: 3.0, m: 2.5 },
                Some([0.0, 0.0, 0.5]),
            ),
            $check("TorusByDistance", TorusByDistance { major: 1.5, minor: 0.5 }, Some([2.0, 0.0, 0.0])),
            $check("Torus", Torus { major: 1.5, minor: 0.5 }, Some([2.0, 0.0, 0.0])),
            $check("Gyroid", Gyroid { k: 1.0, epsilon: 0.0 }, Some([0.0, 0.0, 0.0])),
            $check("Primitive", Primitive { k: 1.0, epsilon: 1.0 }, None),
            $check("Diamond", Diamond { k: 1.0, epsilon: 0.0 }, None),
            $check("Neovius", Neovius { k: 1.0 }, None),
            $check("IWrappedPackage", IWrappedPackage { k: 1.0 }, None),
            $check("Lidinoid", Lidinoid { k: 1.0, epsilon: 0.3 }, None),
            $check("Lemniscate", Lemniscate { a: 1.0, r: 0.125 }, Some([0.0, 0.0, 0.125])),
            $check("ThreeFoci", ThreeFoci { a: 1.0, c: 1.0, r: 0.25 }, Some([0.0, 0.0, 0.25])),
            $check("Clebsch", Clebsch {}, None),
            $check("Cayley", Cayley {}, Some([0.5, 0.0, 0.0])),
            $check("BarthSextic", BarthSextic { w: 1.0 }, None),
            $check("Kummer", Kummer { mu: 1.25 }, None),
            $check("Tanglecube", Tanglecube { c: 11.8 }, None),
            $check("Chmutov", Chmutov {}, None),
            $check("Decocube", Decocube { b: 0.02, c: 0.95 }, None),
            $check("Heart", Heart {}, Some([1.0, 0.0, 0.0])),
            $check("DupinCyclide", DupinCyclide { a: 1.5, b: 1.25, d: 0.5 }, None),
            $check("Metaballs", Metaballs { c: 1.0, level: 2.0 }, Some([0.0, 0.0, 0.0])),
            $check("Hyperboloid", Hyperboloid { a: 1.0, c: 1.5 }, Some([1.0, 0.0, 0.0])),
            $check("Paraboloid", Paraboloid { a: 1.0, b: 1.5 }, Some([1.0, 0.0, 1.0])),
            $check("Saddle", Saddle { a: 1.0, b: 1.5 }, Some([1.0, 0.0, 1.0])),
            $check("MonkeySaddle", MonkeySaddle {}, Some([1.0, 0.0, 1.0])),
            $check("Catenoid", Catenoid { a: 0.5 }, Some([0.5, 0.0, 0.0])),
            $check("Helicoid", Helicoid { c: 0.5 }, Some([1.0, 0.0, 0.0])),
            $check("Scherk", Scherk {}, Some([0.5, 0.5, 0.0])),
        ]
    };
}
