#include <wayfare/decode/ti_decoder.hpp>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "decode/trimmed.hpp"

namespace wayfare::decode {

namespace {

/// One command with its arguments and the line it is on.
struct Command {
  std::string_view name, text;
  std::vector<std::string_view> arguments;
  std::size_t line = 0;
};

std::optional<Command> command_of(std::string_view line, std::size_t number) {
  std::string_view rest = trimmed(line);
  if (rest.empty() || rest.front() == '%') return std::nullopt;
  const auto word = [&] {
    const std::string_view first = rest.substr(0, rest.find_first_of(" \t"));
    rest = trimmed(rest.substr(first.size()));
    return first;
  };
  Command command{{}, rest, {}, number};
  command.name = word();
  while (!rest.empty()) command.arguments.push_back(word());
  return command;
}

std::optional<double> number_of(std::string_view word) {
  double value = 0.0;
  const auto [end, fault] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (fault != std::errc() || end != word.data() + word.size() || !std::isfinite(value))
    return std::nullopt;
  return value;
}

/// The actual slope of the chip's synthesizer, Hz/s.
double ramp_slope(const TiProfile& p) {
  const double reference_mhz = p.start_ghz < 70.0 ? 2700.0 : 3600.0;
  const double unit = reference_mhz * 900.0 / 0x1p26;  // MHz/µs
  return 1e12 * unit * std::floor(p.slope_mhz_per_us / unit);
}

/// Reads the commands in order; keeps the first error.
class Reader {
 public:
  explicit Reader(const std::string& source) : source_(source) {}

  Result<TiConfig> read(std::string_view text) {
    std::size_t number = 0;
    while (!text.empty() && !error_) {
      const std::size_t end = std::min(text.find('\n'), text.size());
      if (const auto command = command_of(text.substr(0, end), ++number)) take(*command);
      text.remove_prefix(std::min(end + 1, text.size()));
    }
    if (!error_) check();
    if (error_) return *error_;
    return config_;
  }

 private:
  struct Entry {
    std::size_t min_arguments = 0;
    void (Reader::*take)(const Command&) = nullptr;
  };
  static const std::map<std::string_view, Entry>& entries() {
    static const std::map<std::string_view, Entry> kEntries = {
        {"dfeDataOutputMode", {1, &Reader::mode}}, {"channelCfg", {2, &Reader::channel}},
        {"profileCfg", {14, &Reader::profile}},    {"chirpCfg", {8, &Reader::chirp}},
        {"frameCfg", {5, &Reader::frame}},         {"cfarCfg", {8, &Reader::cfar}},
        {"clutterRemoval", {2, &Reader::clutter}}, {"extendedMaxVelocity", {2, &Reader::extended}},
        {"aoaFovCfg", {5, &Reader::angles}},       {"cfarFovCfg", {4, &Reader::ranges}}};
    return kEntries;
  }

  void take(const Command& command) {
    if (command.name == "advFrameCfg" || command.name == "subFrameCfg")
      return fail(ErrorCode::unsupported, "advanced frames are not supported", command.line);
    const auto entry = entries().find(command.name);
    if (entry == entries().end()) {
      config_.others.emplace_back(command.text);
      return;
    }
    const auto& [min_arguments, handler] = entry->second;
    if (command.arguments.size() < min_arguments) {
      return fail(command, ErrorCode::parse,
                  "expected at least " + std::to_string(min_arguments) + " arguments, found " +
                      std::to_string(command.arguments.size()));
    }
    seen_.insert(entry->first);
    (this->*handler)(command);
  }

  void fail(ErrorCode code, std::string message, std::size_t line = 0) {
    if (!error_) error_ = Error{code, std::move(message), source_, line};
  }
  void fail(const Command& c, ErrorCode code, const std::string& what) {
    fail(code, std::string(c.name) + ": " + what, c.line);
  }

  double value(const Command& c, std::size_t i) {
    const auto number = number_of(c.arguments[i]);
    if (!number)
      fail(c, ErrorCode::parse,
           "argument " + std::to_string(i + 1) + ", '" + std::string(c.arguments[i]) +
               "', is not a number");
    return number.value_or(0.0);
  }

  int whole(const Command& c, std::size_t i) {
    const double number = value(c, i);
    if (number == std::floor(number) && std::abs(number) <= 1e6) return static_cast<int>(number);
    fail(c, ErrorCode::parse,
         "argument " + std::to_string(i + 1) + " is not an integer up to 1000000");
    return 0;
  }

  unsigned mask(const Command& c, std::size_t i, int bits) {
    const int number = whole(c, i);
    if (number >= 0 && number < 1 << bits) return static_cast<unsigned>(number);
    fail(c, ErrorCode::invalid, "mask " + std::to_string(number) + " is out of range");
    return 0;
  }

  void mode(const Command& c) {
    if (whole(c, 0) != 1) fail(c, ErrorCode::unsupported, "only frames (1) are supported");
  }

  void channel(const Command& c) {
    config_.rx_mask = mask(c, 0, 4);
    config_.tx_mask = mask(c, 1, 3);
    if (config_.rx_mask == 0 || config_.tx_mask == 0)
      fail(c, ErrorCode::invalid, "needs a receiver and a transmitter");
  }

  void profile(const Command& c) {
    TiProfile p;
    p.id = whole(c, 0);
    p.start_ghz = value(c, 1);
    p.idle_us = value(c, 2);
    p.adc_start_us = value(c, 3);
    p.ramp_end_us = value(c, 4);
    p.slope_mhz_per_us = value(c, 7);
    p.samples = whole(c, 9);
    p.sample_ksps = value(c, 10);
    p.gain_db = value(c, 13);
    profiles_[p.id] = p;
  }

  void chirp(const Command& c) {
    const TiChirp chirp{whole(c, 0), whole(c, 1), whole(c, 2), mask(c, 7, 3)};
    if (chirp.first < 0 || chirp.last < chirp.first || chirp.last > 511 || chirp.tx_mask == 0)
      fail(c, ErrorCode::invalid, "invalid range of chirps, or no transmitter");
    config_.chirps.push_back(chirp);
  }

  void frame(const Command& c) {
    config_.frame = {whole(c, 0), whole(c, 1), whole(c, 2), whole(c, 3), value(c, 4)};
    const TiFrameTiming& f = config_.frame;
    if (f.first_chirp < 0 || f.last_chirp < f.first_chirp || f.last_chirp > 511 || f.loops < 1 ||
        f.loops > 255 || f.frames < 0 || !(f.period_ms > 0.0))
      fail(c, ErrorCode::invalid, "invalid chirps, loops or period");
  }

  void cfar(const Command& c) {
    const int direction = whole(c, 1);
    if (direction != 0 && direction != 1)
      return fail(c, ErrorCode::invalid, "direction is 0 (range) or 1 (Doppler)");
    config_.cfar[static_cast<std::size_t>(direction)] = {true, value(c, 7)};
  }

  void clutter(const Command& c) { config_.clutter_removal = whole(c, 1) != 0; }

  void extended(const Command& c) { config_.extended_velocity = whole(c, 1) != 0; }

  void angles(const Command& c) {
    config_.min_azimuth = Angle::degrees(value(c, 1));
    config_.max_azimuth = Angle::degrees(value(c, 2));
    config_.min_elevation = Angle::degrees(value(c, 3));
    config_.max_elevation = Angle::degrees(value(c, 4));
  }

  void ranges(const Command& c) {
    const int direction = whole(c, 1);
    const double low = value(c, 2), high = value(c, 3);
    if ((direction != 0 && direction != 1) || !(low <= high))
      return fail(c, ErrorCode::invalid, "expected direction 0 or 1, then minimum and maximum");
    (direction == 0 ? config_.min_range_m : config_.min_speed_mps) = low;
    (direction == 0 ? config_.max_range_m : config_.max_speed_mps) = high;
  }

  /// The chip's limits, and the sampling time within one ramp.
  void check_profile(const TiProfile& p) {
    const double sampling_us = 1e3 * p.samples / p.sample_ksps;
    const auto require = [&](bool good, const char* what) {
      if (!good) fail(ErrorCode::invalid, "profileCfg " + std::to_string(p.id) + ": " + what);
    };
    require((p.start_ghz >= 76.0 && p.start_ghz <= 81.0) ||
                (p.start_ghz >= 57.0 && p.start_ghz <= 64.0),
            "start frequency outside 57 to 64 and 76 to 81 GHz");
    require(p.samples >= 2 && p.samples <= 8192, "number of samples out of range");
    require(p.sample_ksps > 0.0 && p.sample_ksps <= 37500.0, "sampling rate out of range");
    require(p.idle_us >= 0.0 && p.adc_start_us >= 0.0, "negative time");
    require(ramp_slope(p) > 0.0 && p.slope_mhz_per_us <= 300.0, "slope out of range");
    require(p.adc_start_us + sampling_us <= p.ramp_end_us, "sampling ends after the ramp");
    const double end_ghz = p.start_ghz + 1e-3 * p.slope_mhz_per_us * p.ramp_end_us;
    require(end_ghz <= (p.start_ghz < 70.0 ? 64.0 : 81.0) + 1e-6, "ramp leaves the band");
  }

  /// The chirps of the frame exist, have one profile, and fit into the period.
  void check_frame() {
    const TiFrameTiming& f = config_.frame;
    std::optional<int> profile;
    for (int i = f.first_chirp; i <= f.last_chirp; ++i) {
      const auto chirp =
          std::find_if(config_.chirps.begin(), config_.chirps.end(),
                       [i](const TiChirp& c) { return c.first <= i && i <= c.last; });
      if (chirp == config_.chirps.end())
        return fail(ErrorCode::invalid, "frameCfg: chirp " + std::to_string(i) + " is not defined");
      if ((chirp->tx_mask & ~config_.tx_mask) != 0)
        return fail(ErrorCode::invalid, "chirpCfg: uses a transmitter that channelCfg leaves off");
      if (profile && *profile != chirp->profile)
        return fail(ErrorCode::unsupported, "frameCfg: chirps of different profiles in one frame");
      profile = chirp->profile;
    }
    if (!profile || !profiles_.contains(*profile))
      return fail(ErrorCode::invalid, "chirpCfg: its profile is not defined");
    config_.profile = profiles_[*profile];
    const double chirp_us = config_.profile.idle_us + config_.profile.ramp_end_us;
    const double active_ms = 1e-3 * chirp_us * (f.last_chirp - f.first_chirp + 1) * f.loops;
    if (active_ms > f.period_ms)
      fail(ErrorCode::invalid, "frameCfg: its chirps last longer than its period");
  }

  void check() {
    for (const std::string_view name : {"channelCfg", "profileCfg", "chirpCfg", "frameCfg"})
      if (!seen_.contains(name)) fail(ErrorCode::not_found, "missing command " + std::string(name));
    for (const auto& [id, profile] : profiles_) check_profile(profile);
    if (!error_) check_frame();
  }

  std::string source_;
  TiConfig config_;
  std::map<int, TiProfile> profiles_;
  std::set<std::string_view> seen_;
  std::optional<Error> error_;
};

}  // namespace

Result<TiConfig> parse_ti_config(std::string_view text, const std::string& source) {
  return Reader(source).read(text);
}

TiLimits limits_of(const TiConfig& config) {
  constexpr double kLight = 3e8;
  constexpr int kAngleBins = 64;
  const TiProfile& p = config.profile;
  const double slope = ramp_slope(p), rate = 1e3 * p.sample_ksps;

  std::set<unsigned> tx_masks;
  unsigned transmitters = 0;
  for (const TiChirp& chirp : config.chirps) {
    if (chirp.last < config.frame.first_chirp || chirp.first > config.frame.last_chirp) continue;
    tx_masks.insert(chirp.tx_mask);
    transmitters |= chirp.tx_mask;
  }
  TiLimits l;
  l.transmitters = static_cast<int>(tx_masks.size());
  l.bandwidth_hz = slope * p.samples / rate;
  l.centre_hz = 1e9 * p.start_ghz + slope * 1e-6 * p.adc_start_us + 0.5 * l.bandwidth_hz;
  l.range_bins = static_cast<int>(std::bit_ceil(static_cast<unsigned>(p.samples)));
  l.range_step_m = kLight * rate / (2.0 * slope * l.range_bins);
  l.range_resolution_m = kLight / (2.0 * l.bandwidth_hz);
  l.max_range_m = l.range_step_m * (l.range_bins - 1);
  if (config.max_range_m > 0.0) l.max_range_m = std::min(l.max_range_m, config.max_range_m);

  const int chirps = (config.frame.last_chirp - config.frame.first_chirp + 1) * config.frame.loops;
  const int chirps_per_transmitter = std::max(1, chirps / std::max(1, l.transmitters));
  l.doppler_bins = static_cast<int>(std::bit_ceil(static_cast<unsigned>(chirps_per_transmitter)));
  const double chirp_s = 1e-6 * (p.idle_us + p.ramp_end_us) * l.transmitters;
  l.speed_step_mps = kLight / (2.0 * l.centre_hz * chirp_s * l.doppler_bins);
  l.max_speed_mps = 0.5 * l.speed_step_mps * l.doppler_bins * (config.extended_velocity ? 2 : 1);

  // TX2 is half a wavelength above the others: its virtual antennas measure elevation.
  l.azimuth_antennas =
      std::popcount(config.rx_mask) * std::max(1, std::popcount(transmitters & 5U));
  l.azimuth_resolution = Angle::radians(2.0 / l.azimuth_antennas);
  l.sin_azimuth_step = 2.0 / kAngleBins;
  return l;
}

}  // namespace wayfare::decode
