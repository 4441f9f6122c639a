//! Conversions from and to the types of math crates, one feature each.

#[cfg(feature = "glam")]
mod of_glam {
    use glam::{Affine3, Affine3A, Mat4, Vec2, Vec3, Vec3A, Vec4};

    use crate::geometry::{Affine, Interpolate};

    impl From<Affine3A> for Affine {
        fn from(map: Affine3A) -> Self {
            let [x, y, z] = [map.matrix3.x_axis, map.matrix3.y_axis, map.matrix3.z_axis];
            Self::from_columns(x.into(), y.into(), z.into(), map.translation.into())
        }
    }

    impl From<Affine> for Affine3A {
        fn from(map: Affine) -> Self {
            let [x, y, z, translation] = columns(&map).map(Vec3A::from);
            Self::from_cols(x, y, z, translation)
        }
    }

    impl From<Affine3> for Affine {
        fn from(map: Affine3) -> Self {
            Self::from(Affine3A::from(map))
        }
    }

    impl From<Affine> for Affine3 {
        fn from(map: Affine) -> Self {
            Self::from(Affine3A::from(map))
        }
    }

    /// The way back, of a matrix whose last row is (0, 0, 0, 1), is `glam::Affine3A::from_mat4`.
    impl From<Affine> for Mat4 {
        fn from(map: Affine) -> Self {
            Self::from(Affine3A::from(map))
        }
    }

    fn columns(map: &Affine) -> [[f32; 3]; 4] {
        [map.x_axis, map.y_axis, map.z_axis, map.translation]
    }

    macro_rules! interpolate {
        ($($vector:ty),*) => {$(
            impl Interpolate for $vector {
                fn weighted([a, b, c]: [Self; 3], [wa, wb, wc]: [f32; 3]) -> Self {
                    a * wa + b * wb + c * wc
                }
            }
        )*};
    }

    interpolate!(Vec2, Vec3, Vec3A, Vec4);
}

#[cfg(feature = "mint")]
mod of_mint {
    use mint::{ColumnMatrix3x4, ColumnMatrix4, RowMatrix3x4};

    use crate::geometry::Affine;

    impl From<ColumnMatrix3x4<f32>> for Affine {
        fn from(map: ColumnMatrix3x4<f32>) -> Self {
            Self::from_columns(map.x.into(), map.y.into(), map.z.into(), map.w.into())
        }
    }

    impl From<Affine> for ColumnMatrix3x4<f32> {
        fn from(map: Affine) -> Self {
            Self { x: map.x_axis.into(), y: map.y_axis.into(), z: map.z_axis.into(), w: map.translation.into() }
        }
    }

    impl From<RowMatrix3x4<f32>> for Affine {
        fn from(map: RowMatrix3x4<f32>) -> Self {
            Self::from(ColumnMatrix3x4::from(map))
        }
    }

    impl From<Affine> for RowMatrix3x4<f32> {
        fn from(map: Affine) -> Self {
            Self::from(ColumnMatrix3x4::from(map))
        }
    }

    /// There is no way back: a matrix of four rows may be no affine map.
    impl From<Affine> for ColumnMatrix4<f32> {
        fn from(map: Affine) -> Self {
            let column = |[x, y, z]: [f32; 3], w| [x, y, z, w].into();
            Self {
                x: column(map.x_axis, 0.0),
                y: column(map.y_axis, 0.0),
                z: column(map.z_axis, 0.0),
                w: column(map.translation, 1.0),
            }
        }
    }
}
