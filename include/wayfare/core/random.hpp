#pragma once

// A seeded generator with independent streams: results do not depend on the number of threads, nor,
// unlike those of the standard library's distributions, on the implementation.

#include <array>
#include <bit>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <type_traits>

#include <wayfare/core/contract.hpp>

namespace wayfare {

/// xoshiro256++ (Blackman and Vigna 2019), seeded through SplitMix64.
class Rng {
 public:
  using result_type = std::uint64_t;  ///< as of the standard library's generators

  /// The same seed gives the same numbers.
  explicit Rng(std::uint64_t seed) : seed_(seed) {
    for (auto& word : state_) word = split_mix(seed);
  }

  /// The generator of stream `index` of this seed: independent of this one, of every other stream
  /// and of the numbers drawn before.
  [[nodiscard]] Rng stream(std::uint64_t index) const {
    std::uint64_t mixed = seed_ ^ (0xd1342543de82ef95ULL * (index + 1));
    return Rng(split_mix(mixed));
  }

  /// @{
  /// Of the generator's numbers.
  static constexpr result_type min() { return 0; }
  static constexpr result_type max() { return std::numeric_limits<result_type>::max(); }
  /// @}

  /// 64 random bits.
  result_type operator()() {
    auto& s = state_;
    const std::uint64_t result = std::rotl(s[0] + s[3], 23) + s[0];
    const std::uint64_t t = s[1] << 17;
    s[2] ^= s[0];
    s[3] ^= s[1];
    s[1] ^= s[2];
    s[0] ^= s[3];
    s[2] ^= t;
    s[3] = std::rotl(s[3], 45);
    return result;
  }

  /// Uniform in [0, 1), 53 random bits.
  double uniform() { return static_cast<double>((*this)() >> 11) * 0x1.0p-53; }
  /// Uniform in [low, high).
  double uniform(double low, double high) { return low + (high - low) * uniform(); }

  /// Uniform in {0, …, n-1}, n > 0, as an index: std::size_t, or std::uint64_t where n is of a
  /// wider type. Rejection sampling with the fewest bits.
  template <std::integral Count>
  auto below(Count n) {
    using Index =
        std::conditional_t<(sizeof(Count) > sizeof(std::size_t)), std::uint64_t, std::size_t>;
    WAYFARE_EXPECTS(n > 0, "the number of values must be positive");
    const auto count = static_cast<std::uint64_t>(n);
    if (count <= 1) return Index{0};
    const int unused_bits = std::countl_zero(count - 1);
    while (true) {
      const std::uint64_t draw = (*this)() >> unused_bits;
      if (draw < count) return static_cast<Index>(draw);
    }
  }

  /// Standard normal, Box-Muller; the second value of each pair is kept for the next call.
  double normal() {
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    const double phase = 2.0 * std::numbers::pi * uniform();
    spare_ = radius * std::sin(phase);
    has_spare_ = true;
    return radius * std::cos(phase);
  }
  /// Normal with this mean and standard deviation.
  double normal(double mean, double sigma) { return mean + sigma * normal(); }

 private:
  static std::uint64_t split_mix(std::uint64_t& x) {
    std::uint64_t z = (x += 0x9e3779b97f4a7c15ULL);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
  }

  std::uint64_t seed_;
  std::array<std::uint64_t, 4> state_{};
  double spare_ = 0.0;
  bool has_spare_ = false;
};

}  // namespace wayfare
