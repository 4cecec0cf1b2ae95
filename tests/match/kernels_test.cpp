// All instruction sets this CPU supports give bit-identical results to the portable build.

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "kernel_case.hpp"

namespace wayfare {
namespace {

TEST(Kernels, VariantsAreBitIdentical) {
  for_each_variant([](const Kernels& variant, const Kernels& portable) {
    Rng rng(21);
    for (int i = 0; i < 200; ++i) {
      const KernelCase test(rng);
      Ints u, v, pu, pv;
      test.place(variant, u, v);
      test.place(portable, pu, pv);
      ASSERT_EQ(u, pu);
      ASSERT_EQ(v, pv);
      const int rows = 1 + i % 16;
      ASSERT_EQ(test.block_scores(variant, rows), test.block_scores(portable, rows));
      const auto a = test.linearise(variant), b = test.linearise(portable);
      ASSERT_EQ(std::memcmp(a.data(), b.data(), sizeof(double) * a.size()), 0);
      ASSERT_EQ(test.squares(variant.bilinear_squares), test.squares(portable.bilinear_squares));
      ASSERT_EQ(test.squares(variant.bicubic_squares), test.squares(portable.bicubic_squares));
    }
  });
}

/// Weights of the four cells about a point by the definition of the interpolation: linear, or cubic
/// through the middle two with the slopes of their neighbours' differences.
std::array<double, 4> weights(bool cubic, double t) {
  if (!cubic) return {0, 1 - t, t, 0};
  std::array<double, 4> w{};
  for (std::size_t k = 0; k < 4; ++k) {
    const auto p = [&](std::size_t i) { return i == k ? 1.0 : 0.0; };
    const double m1 = (p(2) - p(0)) / 2, m2 = (p(3) - p(1)) / 2;  // Hermite tangents
    const double t2 = t * t, t3 = t2 * t;
    w[k] = (2 * t3 - 3 * t2 + 1) * p(1) + (t3 - 2 * t2 + t) * m1 + (3 * t2 - 2 * t3) * p(2) +
           (t3 - t2) * m2;
  }
  return w;
}

double interpolated(const LikelihoodField& grid, bool cubic, double u, double v) {
  const int column = static_cast<int>(std::floor(u)), row = static_cast<int>(std::floor(v));
  const auto wu = weights(cubic, u - column), wv = weights(cubic, v - row);
  double f = 0;
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 4; ++x)
      f += wu[static_cast<std::size_t>(x)] * wv[static_cast<std::size_t>(y)] *
           grid.value(grid.origin() + Cell{column - 1 + x, row - 1 + y});
  return f;
}

/// Single precision: sums of up to 700 terms of 4080² agree to some 10⁻⁵.
TEST(Kernels, SquaresAreThoseOfTheInterpolatedField) {
  Rng rng(26);
  const Kernels& k = kernels::best_kernels();
  for (int i = 0; i < 40; ++i) {
    KernelCase test(rng);
    test.x[0] = test.y[0] = 0;  // no point beyond the clamped border
    const double scale =
        std::hypot(static_cast<double>(test.transform.c), static_cast<double>(test.transform.s));
    for (const bool cubic : {false, true}) {
      std::vector<double> want(10, 0.0);
      double size = 0;
      const auto at = [&](double px, double py, double dx, double dy, double heading) {
        // A step in the points' own axes, cells and radians.
        const double c = static_cast<double>(test.transform.c),
                     s = static_cast<double>(test.transform.s);
        const double x = px * std::cos(heading) - py * std::sin(heading) + dx / scale;
        const double y = px * std::sin(heading) + py * std::cos(heading) + dy / scale;
        const auto inside = [](double t, int size_cells) {
          return std::clamp(t, -4.0, static_cast<double>(size_cells) + 4.0);
        };
        return interpolated(
            test.grid, cubic,
            inside(c * x - s * y + static_cast<double>(test.transform.ox), test.grid.width()),
            inside(s * x + c * y + static_cast<double>(test.transform.oy), test.grid.height()));
      };
      for (std::size_t j = 0; j < static_cast<std::size_t>(test.n); ++j) {
        const double px = static_cast<double>(test.x[j]), py = static_cast<double>(test.y[j]);
        const double h = 1e-5, r = 4080 - at(px, py, 0, 0, 0);
        const double g0 = (at(px, py, h, 0, 0) - at(px, py, -h, 0, 0)) / (2 * h);
        const double g1 = (at(px, py, 0, h, 0) - at(px, py, 0, -h, 0)) / (2 * h);
        const double g2 = (at(px, py, 0, 0, h) - at(px, py, 0, 0, -h)) / (2 * h) / scale;
        const double terms[] = {r * r,   r * g0,  r * g1,  r * g2,  g0 * g0,
                                g0 * g1, g0 * g2, g1 * g1, g1 * g2, g2 * g2};
        for (std::size_t m = 0; m < 10; ++m) want[m] += terms[m];
        size += r * r + g0 * g0 + g1 * g1 + g2 * g2;
      }
      const auto got = test.squares(cubic ? k.bicubic_squares : k.bilinear_squares);
      for (std::size_t m = 0; m < 10; ++m) EXPECT_NEAR(got[m], want[m], 2e-3 * size) << m;
    }
  }
}

TEST(Kernels, InterleaveAndSixteenthsEqualTheirDefinition) {
  for_each_variant([](const Kernels& variant, const Kernels&) {
    Rng rng(25);
    for (int n = 1; n < 70; ++n) {
      const auto size = static_cast<std::size_t>(4 * n);
      std::vector<std::uint8_t> in[4], out[4];
      std::vector<std::uint16_t> values(size);
      for (auto& row : in) {
        row.resize(size);
        for (auto& t : row) t = static_cast<std::uint8_t>(rng.below(256));
      }
      for (auto& row : out) row.resize(size);
      for (auto& t : values) t = static_cast<std::uint16_t>(rng.below(4081));
      const std::uint8_t* const from[] = {in[0].data(), in[1].data(), in[2].data(), in[3].data()};
      std::uint8_t* const to[] = {out[0].data(), out[1].data(), out[2].data(), out[3].data()};
      variant.interleave(from, n, to);
      for (std::size_t e = 0; e < size / 4; ++e)
        for (std::size_t p = 0; p < 4; ++p)
          for (std::size_t j = 0; j < 4; ++j) ASSERT_EQ(out[p][4 * e + j], in[j][4 * e + p]);
      std::vector<std::uint8_t> rounded(size);
      variant.sixteenths(values.data(), 4 * n, rounded.data());
      for (std::size_t i = 0; i < size; ++i) ASSERT_EQ(rounded[i], (values[i] + 15) / 16);
    }
  });
}

TEST(Kernels, StampAndMaximaEqualTheirDefinition) {
  for_each_variant([](const Kernels& variant, const Kernels&) {
    Rng rng(23);
    const auto word = [&] { return static_cast<std::uint16_t>(rng.below(4081)); };
    for (int n = 1; n < 100; ++n) {
      const auto size = static_cast<std::size_t>(n);
      std::vector<std::uint8_t> a(size), b(size);
      Ints values(size);
      for (std::size_t i = 0; i < size; ++i) {
        a[i] = static_cast<std::uint8_t>(rng.below(256));
        b[i] = static_cast<std::uint8_t>(rng.below(256));
        values[i] = static_cast<std::int32_t>(rng.below(2000)) - 1000;
      }
      auto larger = a;
      variant.max_into(larger.data(), b.data(), n);
      for (std::size_t i = 0; i < size; ++i) ASSERT_EQ(larger[i], std::max(a[i], b[i]));
      std::int32_t low = 0, high = 0;
      variant.min_max(values.data(), n, &low, &high);
      const auto [least, most] = std::minmax_element(values.begin(), values.end());
      ASSERT_EQ(low, *least);
      ASSERT_EQ(high, *most);

      const int width = 16 * (1 + n % 4), rows = 1 + n % 5, stride = 80;
      std::vector<std::uint16_t> target(static_cast<std::size_t>(stride * rows));
      std::vector<std::uint16_t> kernel(static_cast<std::size_t>(width * rows));
      for (auto& t : target) t = word();
      for (auto& t : kernel) t = word();
      auto want = target;
      for (int r = 0; r < rows; ++r)
        for (int c = 0; c < width; ++c) {
          auto& t = want[static_cast<std::size_t>(r * stride + c)];
          t = std::max(t, kernel[static_cast<std::size_t>(r * width + c)]);
        }
      variant.stamp(target.data(), stride, kernel.data(), width, rows);
      ASSERT_EQ(target, want);
    }
  });
}

std::vector<float> random_floats(Rng& rng, std::size_t n, double half) {
  std::vector<float> values(n);
  for (float& v : values) v = static_cast<float>(rng.uniform(-half, half));
  return values;
}

/// ½ Σ ln(1 + r²/σ²) and its derivatives, in double precision.
TEST(Kernels, LineSquaresAreThoseOfTheResiduals) {
  for_each_variant([](const Kernels& variant, const Kernels& portable) {
    Rng rng(27);
    for (int round = 0; round < 50; ++round) {
      const int n = 1 + static_cast<int>(rng.below(900));
      const auto padded = static_cast<std::size_t>((n + 15) / 16 * 16);
      std::vector<float> arrays[6];
      for (auto& a : arrays) {
        a = random_floats(rng, padded, 5.0);
        std::fill(a.begin() + n, a.end(), 0.0F);
      }
      const auto& [px, py, qx, qy, nx, ny] = arrays;
      const kernels::PointLines lines{px.data(), py.data(), qx.data(), qy.data(),
                                      nx.data(), ny.data(), n};
      const double heading = rng.uniform(-3, 3), information = std::exp(rng.uniform(-7, 7));
      const kernels::CellTransform t{static_cast<float>(std::cos(heading)),
                                     static_cast<float>(std::sin(heading)),
                                     0.3F,
                                     -0.7F,
                                     0,
                                     0,
                                     0};
      std::array<double, 10> got{}, same{}, want{};
      variant.line_squares(lines, t, static_cast<float>(information), got.data());
      portable.line_squares(lines, t, static_cast<float>(information), same.data());
      ASSERT_EQ(got, same);
      double size = 0;
      for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) {
        const double c = std::cos(heading), s = std::sin(heading);
        const auto at = [i](const std::vector<float>& a) { return static_cast<double>(a[i]); };
        const double u = c * at(px) - s * at(py) + 0.3 - at(qx);
        const double v = s * at(px) + c * at(py) - 0.7 - at(qy);
        const double r = at(nx) * u + at(ny) * v, w = 1 / (1 + r * r * information);
        const double g0 = c * at(nx) + s * at(ny), g1 = c * at(ny) - s * at(nx);
        const double g[] = {g0, g1, at(px) * g1 - at(py) * g0};
        want[0] += std::log1p(r * r * information);
        std::size_t k = 4;
        for (std::size_t a = 0; a < 3; ++a) {
          want[1 + a] += w * r * g[a];
          for (std::size_t b = a; b < 3; ++b) want[k++] += w * g[a] * g[b];
        }
        size += w * (g[0] * g[0] + g[1] * g[1] + g[2] * g[2] + std::abs(r * g[2]));
      }
      EXPECT_NEAR(got[0], want[0], 1e-5 * want[0]);
      for (std::size_t k = 1; k < 10; ++k) EXPECT_NEAR(got[k], want[k], 3e-4 * size) << k;
    }
  });
}

TEST(Kernels, VariantsOfPointMapsAreBitIdentical) {
  for_each_variant([](const Kernels& variant, const Kernels& portable) {
    Rng rng(28);
    for (int round = 0; round < 30; ++round) {
      const int n = 1 + static_cast<int>(rng.below(400));
      const auto padded = static_cast<std::size_t>((n + 15) / 16 * 16);
      const auto x = random_floats(rng, padded, 3.0), y = random_floats(rng, padded, 3.0);

      const auto packed = random_floats(rng, 8 * 20, 1.0);
      std::vector<std::int32_t> places[4];
      kernels::NdtTable table{{}, packed.data(), 9, 7};
      for (std::size_t t = 0; t < 4; ++t) {
        places[t].resize(11 * 9);
        for (auto& p : places[t]) p = static_cast<std::int32_t>(rng.below(20));
        table.places[t] = places[t].data();
      }
      const kernels::CellTransform transform{0.8F, 0.6F, 0.25F, 0.75F, 4e6F, 4, 3};
      std::array<double, 10> a{}, b{};
      variant.ndt_sums(x.data(), y.data(), n, transform, table, a.data());
      portable.ndt_sums(x.data(), y.data(), n, transform, table, b.data());
      using Bits = std::array<std::uint64_t, 10>;
      ASSERT_EQ(std::bit_cast<Bits>(a), std::bit_cast<Bits>(b));

      // A row of buckets.
      const auto sx = random_floats(rng, 300 + 8, 3.0), sy = random_floats(rng, 300 + 8, 0.1);
      const std::vector<std::uint32_t> first{0, 20, 80, 81, 190, 300};
      const kernels::SurfaceTable surface{sx.data(), sy.data(), first.data(), -2, 0, 5, 1};
      const auto track = [&](const Kernels& k) {
        std::vector<float> known[5];
        for (auto& v : known) v.assign(padded, 0.0F);
        std::vector<std::int32_t> nearest(padded, -1), index(padded);
        std::vector<float> squared(padded), moved = x;
        for (int step = 0; step < 3; ++step) {
          k.nearest(surface, moved.data(), y.data(), n, 0.5F,
                    {known[0].data(), known[1].data(), nearest.data(), known[2].data(),
                     known[3].data(), known[4].data()},
                    index.data(), squared.data());
          for (float& v : moved) v += 0.004F;
        }
        index.resize(static_cast<std::size_t>(n));
        squared.resize(static_cast<std::size_t>(n));
        return std::pair(index, squared);
      };
      ASSERT_EQ(track(variant), track(portable));
    }
  });
}

}  // namespace
}  // namespace wayfare
