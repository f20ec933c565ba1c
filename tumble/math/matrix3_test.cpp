#include "tumble/math/matrix3.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/rotation.hpp"

namespace tumble {
namespace {

constexpr double rounding = 2.3e-16;

const Matrix3 general{{2.0, -1.0, 0.5}, {0.25, 3.0, -0.75}, {1.0, 0.125, -4.0}};
const Matrix3 another{{0.0, 1.0, -2.0}, {3.5, 0.0, 0.25}, {-1.0, 2.0, 8.0}};

double greatest(const Matrix3& m) {
  double out = 0.0;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) out = std::max(out, std::abs(m(i, j)));
  return out;
}

double greatest(const Rotation& a, const Rotation& b) { return greatest(matrix3(a) - matrix3(b)); }

TEST(Matrix3, ElementsAreCountedByRowAndColumn) {
  Matrix3 m = general;
  EXPECT_EQ(m(1, 2), -0.75);
  m(1, 2) = 7.0;
  EXPECT_EQ(m.y.z, 7.0);
  EXPECT_EQ(column(m, 2).y, 7.0);
  set_column(m, 0, {1.0, 2.0, 3.0});
  EXPECT_EQ(m.z.x, 3.0);
  EXPECT_EQ(diagonal_of(m).x, 1.0);
  EXPECT_EQ(greatest(Matrix3{}), 0.0);
}

TEST(Matrix3, ProductIsThatOfTheGeneralMatrices) {
  // the elements are multiples of 1/8 below 100: no rounding
  EXPECT_EQ(dense(general * another).values, (dense(general) * dense(another)).values);
  const Vector3 v{1.0, -2.0, 0.5}, once = general * (another * v), twice = (general * another) * v;
  EXPECT_EQ(norm(once - twice), 0.0);
}

TEST(Matrix3, TransposeTurnsTheProductAround) {
  EXPECT_EQ(greatest(transposed(general * another) - transposed(another) * transposed(general)), 0.0);
  EXPECT_EQ(greatest(matrix3(transposed(dense(general))) - transposed(general)), 0.0);
}

TEST(Matrix3, SumsAreTakenElementByElement) {
  Matrix3 m = general;
  m += another;
  EXPECT_EQ(greatest(m - another - general), 0.0);
  m -= general;
  EXPECT_EQ(greatest(m - another), 0.0);
  EXPECT_EQ(greatest(-m + another), 0.0);
  EXPECT_EQ(greatest(2.0 * m / 2.0 - another), 0.0);
}

TEST(Matrix3, InverseTimesTheMatrixIsTheIdentity) {
  // singular values between 2 and 4.3: the error of 10 rounding s_1^2/(s_2 s_3) times the greatest element of the
  // product
  EXPECT_LT(greatest(inverse(general) * general - identity3()), 50.0 * rounding);
  EXPECT_LT(greatest(general * inverse(general) - identity3()), 50.0 * rounding);
  EXPECT_LT(greatest(inverse(general) - matrix3(inverse(dense(general)))), 20.0 * rounding);
}

TEST(Matrix3, InverseOfASingularMatrixIsNotFinite) {
  const Matrix3 m = outer({1.0, 2.0, 3.0}, {4.0, 5.0, 6.0});  // integers: the determinant is 0 exactly
  EXPECT_EQ(determinant(m), 0.0);
  EXPECT_FALSE(is_finite(inverse(m).x));
}

TEST(Matrix3, DeterminantOfAProductIsTheProduct) {
  const double product = determinant(general) * determinant(another);  // sums of multiples of 2^-9: exact
  EXPECT_EQ(determinant(general * another), product);
  EXPECT_NEAR(determinant(dense(general)), determinant(general), 30.0 * rounding * std::abs(determinant(general)));
  EXPECT_EQ(determinant(identity3()), 1.0);
}

TEST(Matrix3, SkewIsTheCrossProduct) {
  const Vector3 v{1.0, -2.0, 3.0}, w{0.5, 4.0, -1.0};
  EXPECT_EQ(norm(skew(v) * w - cross(v, w)), 0.0);
  EXPECT_EQ(greatest(skew(v) + transposed(skew(v))), 0.0);
  // v x (v x w) = v (v w) - w (v v)
  EXPECT_EQ(greatest(skew(v) * skew(v) - (outer(v, v) - dot(v, v) * identity3())), 0.0);
}

TEST(Vector3, HelpersActOnComponents) {
  Vector3 v{3.0, -4.0, 12.0};
  EXPECT_EQ(norm(v), 13.0);
  EXPECT_NEAR(norm(normalised(v)), 1.0, 2.0 * rounding);
  EXPECT_FALSE(is_finite(normalised(Vector3{})));
  EXPECT_EQ(absolute(v)[1], 4.0);
  EXPECT_EQ(scaled(v, v)[2], 144.0);
  v[1] = 5.0;
  v += {1.0, 1.0, 1.0}, v -= {0.0, 0.0, 3.0}, v *= 2.0;
  EXPECT_EQ(norm(v - Vector3{8.0, 12.0, 20.0}), 0.0);
  EXPECT_EQ((-v).y, -12.0);
}

TEST(Vector3, UnitAcrossIsAtARightAngle) {
  for (const Vector3 v : {Vector3{1.0, 2.0, 3.0}, {0.0, 0.0, -5.0}, {1e-14, 0.0, 1.0}, {1e-8, 0.0, 1.0}}) {
    EXPECT_NEAR(norm(unit_across(v)), 1.0, 2.0 * rounding);
    EXPECT_NEAR(dot(unit_across(v), v), 0.0, 4.0 * rounding * norm(v));
  }
}

TEST(Rotation, TurnedByAVectorIsTurnedAboutItsDirection) {
  const Vector3 axis = normalised({1.0, -2.0, 0.5});
  for (const double angle : {1e-9, 1e-3, 0.0999, 0.1001, 1.0, 3.0})  // on both sides of where the series ends
    EXPECT_LT(greatest(turned_by(angle * axis), about(axis, angle)), 1e-14) << angle;
  EXPECT_EQ(greatest(turned_by({}), Rotation{}), 0.0);
}

TEST(Rotation, TurnsAboutOneAxisAdd) {
  const Vector3 axis = normalised({0.3, 0.4, -1.2});
  EXPECT_LT(greatest(turned_by(0.7 * axis) * turned_by(0.05 * axis), turned_by(0.75 * axis)), 1e-14);
  EXPECT_LT(greatest(inverse(turned_by(0.7 * axis)), turned_by(-0.7 * axis)), 4.0 * rounding);
}

TEST(Rotation, InverseTurnsVectorsByTheVector) {
  const Vector3 turned = inverse(turned_by({0.0, 0.0, 0.5 * std::acos(-1.0)})) * Vector3{1.0, 0.0, 0.0};
  EXPECT_LT(norm(turned - Vector3{0.0, 1.0, 0.0}), 4.0 * rounding);
}

}  // namespace
}  // namespace tumble
