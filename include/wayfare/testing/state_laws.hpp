#pragma once

// The laws of composed states, their processes and their measurements, as checks on any type:
//
//   StateLaws<MyState> laws;
//   laws.check_process(my_process, my_input);
//   laws.check_measurement(my_measurement);

#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/filter/ekf.hpp>
#include <wayfare/filter/measurement.hpp>
#include <wayfare/filter/process.hpp>
#include <wayfare/testing/detail/derivatives.hpp>
#include <wayfare/testing/filter_laws.hpp>
#include <wayfare/testing/lie_group_laws.hpp>

namespace wayfare::testing {

/// Fails the current test where a composed state, a process or a measurement breaks its laws.
template <class S>
struct StateLaws {
  S origin{};               ///< from which states are tried
  double scale = 1.0;       ///< size of the steps from `origin` to the states tried
  int trials = 20;          ///< number of states
  double tolerance = 1e-6;  ///< of a derivative, relative to the largest, from 1 up
  std::uint64_t seed = 1;   ///< of the states

  /// The state is a manifold, and its names are distinct.
  void check_state() const {
    ManifoldLaws<S>{}.check();
    std::set<std::string_view> names;
    for (const std::string_view name : S::names()) {
      EXPECT_FALSE(name.empty());
      EXPECT_TRUE(names.insert(name).second) << "two errors named " << name;
    }
  }

  /// Φ is the derivative of the step, Q is a covariance or zero in some directions, and the
  /// prediction of the covariance is ΦPΦᵀ + Q.
  template <class P, class U>
  void check_process(const P& process, const U& input) const {
    for_each_state([&](const S& x, Rng& rng) {
      const auto step = process(x, input);
      JacobianBlocks<S, S> phi{step.phi()};
      expect_derivatives<S>([&](const S& at) { return process(at, input).state; }, step.state, phi,
                            tolerance, x);
      expect_covariance(step.q());
      SquareOf<S> a;
      for (auto& element : a.reshaped()) element = rng.normal();
      const SquareOf<S> p = a * a.transpose() + SquareOf<S>::Identity();
      FilterLaws<S>{Ekf<S>(x, 0.5 * (p + p.transpose()))}.check_predict(process, input);
    });
  }

  /// The Jacobians are the derivatives of the error, the covariance is one, and updates satisfy the
  /// laws of filters.
  template <class H>
  requires MeasurementError<H, S>
  void check_measurement(const H& measurement) const {
    for_each_state([&](const S& x, Rng&) {
      wayfare::detail::with_values<H>(x, [&]<class... V>(const V&... value) {
        using Y = wayfare::detail::ErrorOf<H>;
        JacobianBlocks<Y, V...> by;
        const Y error = linearise_measurement(measurement, by, value...);
        expect_derivatives<Y>([&](const auto&... v) { return measurement.error(v...); }, error, by,
                              tolerance, value...);
      });
      FilterLaws<S>{Ekf<S>(x, SquareOf<S>::Identity())}.check_update(measurement);
    });
  }

 private:
  template <class Check>
  void for_each_state(const Check& check) const {
    Rng rng(seed);
    for (int trial = 0; trial < trials; ++trial) {
      SCOPED_TRACE("trial " + std::to_string(trial));
      TangentOf<S> step;
      for (auto& element : step) element = scale * rng.normal();
      check(origin.plus(step), rng);
    }
  }
};

}  // namespace wayfare::testing
