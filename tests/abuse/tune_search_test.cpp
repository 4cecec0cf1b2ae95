// The genetic search and its fitness with numbers that are none.

#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/tune/genetic.hpp>
#include <wayfare/tune/ins_fitness.hpp>

#include "abuse/abuse.hpp"

namespace wayfare::tests {
namespace {

GeneticOptions few() {
  GeneticOptions o;
  o.population = 8;
  o.elite = 2;
  o.generations = 4;
  return o;
}
const std::vector<Gene> kGenes{{"a", -2.0, 2.0, false}, {"b", 1e-3, 1e3, true}};

void sum_of(std::span<const double> x, std::span<double> scores) {
  for (std::size_t i = 0; i < scores.size(); ++i) scores[i] = x[2 * i] * x[2 * i] + x[2 * i + 1];
}

TEST(GeneAbuse, StaysWithinItsBounds) {
  for (const Gene& g : {kGenes[0], kGenes[1], Gene{"c", 3.0, 3.0, false}, Gene{"d", 3.0, 3.0, true},
                        Gene{"e", 1e-150, 1e150, true}, Gene{"f", -1e307, 1e307, false}})
    for (const double v : {-kInf, kInf, -kHuge, kHuge, 0.0, -0.0, 1.0, kTiny}) {
      EXPECT_TRUE(g.unit(v) >= 0.0 && g.unit(v) <= 1.0) << g.name << ' ' << v;
      const double back = g.value(g.unit(v));
      EXPECT_TRUE(back >= g.low && back <= g.high) << g.name << ' ' << v;
    }
}

TEST(GeneticDeathTest, RefusesSearchesAndStatesThatAreNone) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_DEATH(GeneticSearch({}, few()), "gene");
  EXPECT_DEATH(GeneticSearch({{"a", -kInf, 1.0}}, few()), "bounds");
  EXPECT_DEATH(GeneticSearch({{"a", kNan, 1.0}}, few()), "bounds");
  EXPECT_DEATH(GeneticSearch({{"a", -1e308, 1e308}}, few()), "bounds");
  EXPECT_DEATH(GeneticSearch({{"a", 0.0, 1.0, true}}, few()), "bounds");
  GeneticSearch search(kGenes, few());
  EXPECT_DEATH((void)search.best({}), "state");
  EXPECT_DEATH((void)search.next({}, sum_of), "state");
}

TEST(GeneticAbuse, AKnownIndividualWithNaNIsRestoredFromItsText) {
  const GeneticSearch search(kGenes, few());
  const std::vector<double> known{kNan, 5.0, kInf, -kInf, 1.0};  // the last row is not whole
  const GeneticState state = search.start(sum_of, known);
  for (const double u : state.units) EXPECT_TRUE(u >= 0.0 && u <= 1.0);
  const auto back = search.parse(search.format(state), "memory");
  ASSERT_TRUE(back) << back.error().to_string();
  EXPECT_EQ(back->units, state.units);
}

TEST(GeneticAbuse, AFitnessThatAlwaysFailsEndsAndIsRestored) {
  const GeneticSearch search(kGenes, few());
  for (const double odd : kNotFinite) {
    const auto fail = [odd](auto, std::span<double> scores) {
      for (double& s : scores) s = odd;
    };
    GeneticState state = search.start(fail);
    while (!search.finished(state)) state = search.next(state, fail);
    EXPECT_EQ(state.history.back().failed, 8U);
    EXPECT_EQ(state.history.back().best, kInf);
    ASSERT_TRUE(search.parse(search.format(state), ""));
  }
}

TEST(GeneticAbuse, OddRatesStayInBounds) {
  for (const double odd : {kNan, kInf, -kInf, -1.0, 1e9})
    for (double GeneticOptions::*rate :
         {&GeneticOptions::selection_pressure, &GeneticOptions::crossover_rate,
          &GeneticOptions::mutation_rate}) {
      GeneticOptions o = few();
      o.*rate = odd;
      const GeneticSearch search(kGenes, o);
      GeneticState state = search.start(sum_of);
      for (int i = 0; i < 5; ++i) state = search.next(state, sum_of);
      for (const double u : state.units) EXPECT_TRUE(u >= 0.0 && u <= 1.0);
    }
}

TuningDrive short_drive() {
  TuningDrive drive;
  drive.start.nav.position = {Angle::degrees(51.0), Angle::degrees(-114.0), 1000.0};
  const Eigen::Vector3d here = ecef_from_geodetic(drive.start.nav.position);
  for (int i = 0; i <= 100; ++i) {
    ImuSample s{LogTime::from_seconds(0.05 * i)};
    s.specific_force_mps2.z() = -9.8;
    drive.imu.push_back(s);
  }
  for (int k = 1; k <= 4; ++k) {
    RangeEpoch epoch{LogTime::from_seconds(k), {}};
    for (int i = 0; i < 6; ++i) {
      CorrectedRange r;
      r.satellite.number = static_cast<std::uint8_t>(i + 1);
      r.position_ecef_m =
          here + 2e7 * Eigen::Vector3d(std::cos(i), std::sin(i), 0.3 * i).normalized();
      r.range_m = 2e7;
      r.range_rate_mps = 0.0;
      epoch.satellites.push_back(r);
    }
    drive.ranges.push_back(epoch);
  }
  drive.truth = [nav = drive.start.nav](LogTime t) {
    NavState at = nav;
    at.time = t;
    return std::optional(at);
  };
  return drive;
}

TEST(InsFitnessAbuse, DrivesWithoutContentAreErrors) {
  EXPECT_TRUE(InsFitness::make(short_drive()));
  TuningDrive drive = short_drive();
  drive.imu.clear();
  EXPECT_FALSE(InsFitness::make(drive));
  drive = short_drive();
  drive.ranges.clear();
  EXPECT_FALSE(InsFitness::make(drive));
  drive = short_drive();
  drive.truth = [](LogTime) { return std::optional<NavState>(); };
  EXPECT_FALSE(InsFitness::make(drive));
  drive = short_drive();
  drive.options.imu_time_offset_s = kNan;
  EXPECT_FALSE(InsFitness::make(drive));
  drive.options.imu_time_offset_s = 1e9;
  (void)InsFitness::make(drive);
  InsFitnessOptions options;
  for (const double odd : {kNan, -1.0}) {
    options.score_interval_s = odd;
    EXPECT_FALSE(InsFitness::make(short_drive(), options));
  }
  options = {};
  options.kernel = "none such";
  EXPECT_FALSE(InsFitness::make(short_drive(), options));
}

TEST(InsFitnessAbuse, BrokenReadingsAndGenesScoreInfinityAndNothingElse) {
  const std::vector<double> good = ins_genes(GnssInsOptions{});
  std::vector<double> genes = good;
  for (const double odd : {kNan, kInf, -kInf, 0.0, -1.0, kHuge}) {
    genes.insert(genes.end(), good.begin(), good.end());
    genes[genes.size() - kInsGenes] = odd;
  }
  genes.insert(genes.end(), good.begin(), good.end());
  TuningDrive drive = short_drive();
  drive.ranges[1].satellites[0].range_m = kNan;
  drive.ranges[1].satellites[1].position_ecef_m.setConstant(kInf);
  drive.ranges[2].satellites.clear();
  std::swap(drive.ranges[2], drive.ranges[3]);
  std::swap(drive.imu[3], drive.imu[9]);
  const auto fitness = InsFitness::make(drive);
  ASSERT_TRUE(fitness);
  std::vector<double> scores(genes.size() / kInsGenes, -1.0);
  (*fitness)(genes, scores);
  for (const double s : scores) EXPECT_FALSE(std::isnan(s));
  EXPECT_TRUE(std::isfinite(scores.front()));
  EXPECT_EQ(scores.front(), scores.back());
  (*fitness)({}, {});
  EXPECT_TRUE(fitness->rmse({}).empty());
  drive.imu[50].angular_rate_radps.setConstant(kNan);
  const auto broken = InsFitness::make(drive);
  ASSERT_TRUE(broken);
  (*broken)(good, scores);
  EXPECT_EQ(scores[0], kInf);
}

TEST(TuneAbuse, TwoThreadsSearchTheSame) {
  const auto both = in_two_threads([](int) {
    const auto fitness = InsFitness::make(short_drive());
    GeneticOptions o = few();
    o.generations = 2;
    const GeneticSearch search(ins_gene_bounds(GnssInsOptions{}), o);
    const BatchFitness score = [&](auto x, auto s) { (*fitness)(x, s); };
    return search.format(search.next(search.start(score), score));
  });
  EXPECT_EQ(both[0], both[1]);
}

}  // namespace
}  // namespace wayfare::tests
