// The smoother against least squares over all states of an interval at once, which for linear
// models has the same solution.

#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Core>
#include <Eigen/LU>

#include <wayfare/core/random.hpp>
#include <wayfare/filter/ekf.hpp>
#include <wayfare/filter/smoother.hpp>

namespace wayfare {
namespace {

constexpr int kSize = 4;
using State = Eigen::Matrix<double, kSize, 1>;
using Square = Eigen::Matrix<double, kSize, kSize>;
using Tape = SmootherTape<State>;
using Filter = Ekf<State, TapeRecorder<State>>;

Square random_square(Rng& rng) {
  Square m;
  for (double& x : m.reshaped()) x = rng.normal();
  return m;
}
Square random_covariance(Rng& rng) {
  const Square m = random_square(rng);
  return m * m.transpose() + 0.1 * Square::Identity();
}

struct DenseProcess {
  Square phi, q;
  struct Step {
    State state;
    Square phi, q;
  };
  Step operator()(const State& x) const { return {phi * x, phi, q}; }
};

template <int Rows>
struct Linear {
  Eigen::Matrix<double, Rows, kSize> h;
  Eigen::Matrix<double, Rows, 1> z;
  Eigen::Matrix<double, Rows, Rows> r;
};
struct OneNumber : Linear<1> {
  auto operator()(const State& x) const {
    return ScalarMeasurement<double, Eigen::Matrix<double, 1, kSize>>{z[0] - (h * x)[0], h, r(0)};
  }
};
struct OneElement {
  int index;
  double factor, z, r;
  auto operator()(const State& x) const {
    return ScalarMeasurement<double, SparseRow<double, 1>>{
        z - factor * x[index], {{index}, {factor}}, r};
  }
};

/// The first and the last element, mixed.
struct TwoElements {
  Eigen::Matrix2d factor;
  Eigen::Vector2d z;
  Eigen::Matrix2d r;
  auto operator()(const State& x) const {
    return VectorMeasurement<double, 2, SparseRows<double, 2, 2>>{
        z - factor * Eigen::Vector2d(x[0], x[3]), {{0, 3}, factor}, r};
  }
};

/// All states of an interval, by the information of each prior, step and measurement.
class Batch {
 public:
  explicit Batch(int states)
      : information_(Eigen::MatrixXd::Zero(kSize * states, kSize * states)),
        vector_(Eigen::VectorXd::Zero(kSize * states)) {}
  void prior(int i, const State& mean, const Square& covariance) {
    const Square w = covariance.inverse();
    information_.block<kSize, kSize>(kSize * i, kSize * i) += w;
    vector_.segment<kSize>(kSize * i) += w * mean;
  }
  void step(int i, const Square& phi, const Square& q) {
    Eigen::Matrix<double, kSize, 2 * kSize> j;
    j << -phi, Square::Identity();
    information_.block<2 * kSize, 2 * kSize>(kSize * i, kSize * i) +=
        j.transpose() * q.inverse() * j;
  }
  template <int Rows>
  void measure(int i, const Linear<Rows>& m) {
    information_.block<kSize, kSize>(kSize * i, kSize * i) += m.h.transpose() * m.r.inverse() * m.h;
    vector_.segment<kSize>(kSize * i) += m.h.transpose() * m.r.inverse() * m.z;
  }
  void solve() {
    covariance_ = information_.inverse();
    mean_ = covariance_ * vector_;
  }
  State mean(int i) const { return mean_.segment<kSize>(kSize * i); }
  Square covariance(int i) const { return covariance_.block<kSize, kSize>(kSize * i, kSize * i); }

 private:
  Eigen::MatrixXd information_, covariance_;
  Eigen::VectorXd vector_, mean_;
};

/// A filter, its tape and the same problem as one system of equations.
struct Problem {
  explicit Problem(std::uint64_t seed, int states) : rng(seed), batch(states) {
    const State mean = State::NullaryExpr([this] { return rng.normal(); });
    const Square p = random_covariance(rng);
    filter = Filter(mean, p);
    filter.recorder().tape = &tape;
    batch.prior(0, mean, p);
    mark();
  }
  void mark() { tape.mark(filter.state(), filter.covariance()); }
  void step() {
    const DenseProcess process{random_square(rng), random_covariance(rng)};
    filter.predict(process);
    batch.step(at++, process.phi, process.q);
  }
  void measure() {
    const OneNumber m{{State::NullaryExpr([this] { return rng.normal(); }).transpose(),
                       Eigen::Matrix<double, 1, 1>(rng.normal()),
                       Eigen::Matrix<double, 1, 1>(0.3)}};
    ASSERT_TRUE(filter.update(m).accepted);
    batch.measure(at, static_cast<const Linear<1>&>(m));
    const OneElement element{2, 1.5, rng.normal(), 0.7};
    ASSERT_TRUE(filter.update(element).accepted);
    Linear<1> same{Eigen::Matrix<double, 1, kSize>::Zero(), Eigen::Matrix<double, 1, 1>(element.z),
                   Eigen::Matrix<double, 1, 1>(element.r)};
    same.h[2] = element.factor;
    batch.measure(at, same);
  }
  void measure_two() {
    Linear<2> m{random_square(rng).topRows<2>(), random_square(rng).topLeftCorner<2, 1>(),
                random_covariance(rng).topLeftCorner<2, 2>()};
    ASSERT_TRUE(filter.update_block<2>(m.z - m.h * filter.state(), m.h, m.r));
    batch.measure(at, m);
  }
  void measure_elements() {
    const TwoElements m{random_square(rng).topLeftCorner<2, 2>(),
                        random_square(rng).topLeftCorner<2, 1>(),
                        random_covariance(rng).topLeftCorner<2, 2>()};
    ASSERT_TRUE(filter.update(m).accepted);
    Linear<2> same{Eigen::Matrix<double, 2, kSize>::Zero(), m.z, m.r};
    same.h.col(0) = m.factor.col(0);
    same.h.col(3) = m.factor.col(1);
    batch.measure(at, same);
  }
  void expect_batch() {
    batch.solve();
    SmootherAdjoint<State> adjoint;
    std::size_t left = tape.marks();
    tape.back(adjoint, [&](std::size_t i, const Tape::Mark& mark, const auto& at_mark) {
      EXPECT_EQ(i, --left);
      const Tape::Mark found = smoothed<State>(mark, at_mark);
      const int k = static_cast<int>(i);
      EXPECT_LT((found.state - batch.mean(k)).norm(), 1e-9 * (1.0 + batch.mean(k).norm())) << i;
      EXPECT_LT((found.covariance - batch.covariance(k)).norm(), 1e-9 * mark.covariance.norm())
          << i;
    });
    EXPECT_EQ(left, 0U);
  }

  Rng rng;
  Batch batch;
  Filter filter;
  Tape tape;
  int at = 0;
};

TEST(Smoother, EqualsLeastSquaresOverTheInterval) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    constexpr int kStates = 12;
    Problem p(seed, kStates);
    for (int i = 1; i < kStates; ++i) {
      p.step();
      if (i % 3 != 0) p.measure();
      if (i % 4 == 0) p.measure_two();
      if (i % 5 == 0) p.measure_elements();
      p.mark();
    }
    p.expect_batch();
  }
}

TEST(Smoother, WithoutLaterMeasurementsTheFilterIsRight) {
  Problem p(4, 5);
  for (int i = 1; i < 5; ++i) p.step(), p.mark();
  SmootherAdjoint<State> adjoint;
  p.tape.back(adjoint, [](std::size_t, const Tape::Mark& mark, const auto& at) {
    EXPECT_EQ(smoothed<State>(mark, at).state, mark.state);
    EXPECT_EQ(smoothed<State>(mark, at).covariance, mark.covariance);
  });
  EXPECT_TRUE(adjoint.matrix.isZero(0.0));
}

/// The marks of a problem, smoothed; the newest first.
std::vector<State> all_smoothed(const Tape& tape, SmootherAdjoint<State> adjoint = {}) {
  std::vector<State> states;
  tape.back(adjoint, [&](std::size_t, const Tape::Mark& mark, const auto& at) {
    states.push_back(smoothed<State>(mark, at).state);
  });
  return states;
}

TEST(Smoother, ATapeMayBeReadInPieces) {
  Problem whole(5, 8), parts(5, 8);
  Tape first;
  for (int i = 1; i < 8; ++i) {
    for (Problem* p : {&whole, &parts}) p->step(), p->measure(), p->mark();
    if (i == 4) std::swap(first, parts.tape);
  }
  SmootherAdjoint<State> adjoint;
  std::vector<State> states = all_smoothed(parts.tape);
  parts.tape.back(adjoint, [](auto&&...) {});
  for (const State& x : all_smoothed(first, adjoint)) states.push_back(x);
  EXPECT_EQ(states, all_smoothed(whole.tape));
}

TEST(Smoother, WhatWasRemovedHasNoEffect) {
  Problem p(6, 8), same(6, 8);
  for (int i = 1; i < 4; ++i)
    for (Problem* x : {&p, &same}) x->step(), x->measure(), x->mark();
  const Tape::Place place = p.tape.end();
  const Filter before = p.filter;
  p.measure_two(), p.step(), p.mark(), p.tape.reset(1);
  p.tape.truncate(place);
  p.filter = before;
  p.rng = same.rng;
  p.at = same.at;
  for (int i = 4; i < 8; ++i)
    for (Problem* x : {&p, &same}) x->step(), x->measure(), x->mark();
  const std::vector<State> expected = all_smoothed(same.tape);
  EXPECT_EQ(all_smoothed(p.tape), expected);

  p.tape.drop_marks(3);
  EXPECT_EQ(p.tape.marks(), same.tape.marks() - 3);
  EXPECT_EQ(all_smoothed(p.tape), std::vector<State>(expected.begin(), expected.end() - 3));
}

TEST(Smoother, APlaceMovesWithTheBeginning) {
  Problem p(8, 8);
  for (int i = 1; i < 5; ++i) p.step(), p.measure(), p.mark();
  const std::vector<State> all = all_smoothed(p.tape);
  Tape::Place place = p.tape.end();
  for (int i = 5; i < 8; ++i) p.step(), p.measure_two(), p.mark();
  place -= p.tape.drop_marks(2);
  p.tape.truncate(place);
  EXPECT_EQ(all_smoothed(p.tape), std::vector<State>(all.begin(), all.end() - 2));
}

TEST(Smoother, NothingIsLearntOfWhatWasReplaced) {
  Problem p(7, 4);
  p.step(), p.measure(), p.mark();
  p.filter.reset_variance(1, 9.0);
  p.step(), p.measure();
  SmootherAdjoint<State> adjoint;
  p.tape.back(adjoint, [](std::size_t i, const Tape::Mark&, const auto& at) {
    if (i != 1) return;
    EXPECT_EQ(at.vector[1], 0.0);
    EXPECT_TRUE(at.matrix.row(1).isZero(0.0));
    EXPECT_GT(at.matrix.norm(), 0.0);
  });

  Problem again(7, 4);
  again.step(), again.mark();
  again.tape.restart();
  again.step(), again.measure();
  again.tape.back(adjoint = {}, [](std::size_t, const Tape::Mark&, const auto& at) {
    EXPECT_TRUE(at.matrix.isZero(0.0));
  });
}

}  // namespace
}  // namespace wayfare
