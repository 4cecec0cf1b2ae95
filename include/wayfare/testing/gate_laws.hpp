#pragma once

// The laws of a gate of filter updates, as checks on any type:
//
//   GateLaws<MyGate>{MyGate{3.0}}.check();                    // of scalar measurements
//   GateLaws<MyGate, 2>{MyGate{3.0}}.check();                 // of vectors of two
//   GateLaws<MyGate>{gate}.check_update(filter, measurement);

#include <cmath>
#include <cstdint>
#include <string>

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <wayfare/core/random.hpp>
#include <wayfare/filter/ekf.hpp>
#include <wayfare/testing/filter_laws.hpp>

namespace wayfare::testing {

/// Fails the current test where a gate of innovations of dimension `Dim` breaks its laws.
template <class G, int Dim = 1>
requires UpdateGate<G, double, Dim>
struct GateLaws {
  G gate;                  ///< under test
  int trials = 50;         ///< directions of innovations tried
  std::uint64_t seed = 1;  ///< of the innovations

  /// Weights are from 0 to 1, 1 without an innovation, and do not increase where an innovation
  /// grows in one direction.
  void check() const {
    Rng rng(seed);
    for (int trial = 0; trial < trials; ++trial) {
      SCOPED_TRACE("trial " + std::to_string(trial));
      Block a;
      Column direction;
      for (auto& element : a.reshaped()) element = rng.normal();
      for (auto& element : direction) element = rng.normal();
      const Block s = std::exp(4.0 * rng.normal()) * (a * a.transpose() + 0.1 * Block::Identity());
      direction /= std::sqrt(direction.dot(s.llt().solve(direction)));
      EXPECT_EQ(weight(innovation(0.0 * direction, s)), 1.0) << "without an innovation";
      double last = 1.0;
      for (double sigmas = 1e-3; sigmas < 1e4; sigmas *= 1.3) {
        const double now = weight(innovation(sigmas * direction, s));
        EXPECT_TRUE(now >= 0.0 && now <= 1.0) << "weight " << now << " at " << sigmas << " sigma";
        EXPECT_LE(now, last) << "weight increases at " << sigmas << " sigma";
        last = now;
      }
    }
  }

  /// A weight w is a measurement of covariance R/w; one that is rejected changes nothing.
  template <Manifold M, class Model>
  requires MeasurementModel<Model, M>
  void check_update(const Ekf<M>& filter, const Model& model) const {
    Ekf<M> gated = filter, expected = filter;
    const auto u = gated.update(model, gate);
    const double w = weight(innovation_of(u));
    EXPECT_EQ(u.accepted, w > 0.0);
    if (w > 0.0) expected.update([&](const M& x) { return inflated(measure(model, x), w); });
    FilterLaws<M>{filter}.expect_same(gated.covariance(), expected.covariance(), "R/w");
    EXPECT_LE(ManifoldTraits<M>::minus(gated.state(), expected.state()).norm(), 1e-12) << "R/w";
  }

 private:
  using Column = Eigen::Matrix<double, Dim, 1>;
  using Block = Eigen::Matrix<double, Dim, Dim>;

  [[nodiscard]] double weight(const Innovation<double, Dim>& i) const {
    return static_cast<double>(gate(i));
  }
  [[nodiscard]] static Innovation<double, Dim> innovation(const Column& value, const Block& s) {
    const double nis = value.dot(s.llt().solve(value));
    if constexpr (Dim == 1)
      return {value[0], s(0, 0), nis};
    else
      return {value, s, nis};
  }
  [[nodiscard]] static Innovation<double, 1> innovation_of(const ScalarUpdate<double>& u) {
    return {u.innovation, u.variance, u.nis()};
  }
  template <int Rows>
  [[nodiscard]] static Innovation<double, Rows> innovation_of(const VectorUpdate<double, Rows>& u) {
    return {u.innovation, u.covariance, u.nis};
  }
  template <class Measurement>
  [[nodiscard]] static Measurement inflated(Measurement m, double w) {
    if constexpr (requires { m.variance; })
      m.variance /= w;
    else
      m.covariance /= w;
    return m;
  }
};

}  // namespace wayfare::testing
