#include <wayfare/decode/ti_decoder.hpp>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

namespace wayfare::decode {

namespace {

/// One command with its arguments and the line it is on.
struct Command {
  std::string_view name, text;
  std::vector<std::string_view> arguments;
  std::size_t line = 0;
};

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r";
  const std::size_t first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

std::optional<Command> command_of(std::string_view line, std::size_t number) {
  line = trimmed(line);
  if (line.empty() || line.front() == '%') return std::nullopt;
  Command command{{}, line, {}, number};
  for (std::string_view rest = line; !rest.empty();) {
    const std::size_t end = std::min(rest.find_first_of(" \t"), rest.size());
    const std::string_view word = rest.substr(0, end);
    if (command.name.empty()) {
      command.name = word;
    } else {
      command.arguments.push_back(word);
    }
    rest = trimmed(rest.substr(end));
  }
  return command;
}

std::optional<double> number_of(std::string_view word) {
  double value = 0.0;
  const auto [end, fault] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (fault != std::errc() || end != word.data() + word.size() || !std::isfinite(value))
    return std::nullopt;
  return value;
}

/// Reads the commands in order; keeps the first error.
class Reader {
 public:
  explicit Reader(const std::string& source) : source_(source) {}

  Result<TiConfig> read(std::string_view text);

 private:
  using Handler = void (Reader::*)(const Command&);
  struct Entry {
    std::size_t min_arguments = 0;
    Handler take = nullptr;
  };
  static const std::map<std::string_view, Entry>& entries();

  void take(const Command& command);
  void mode(const Command&);
  void channel(const Command&);
  void profile(const Command&);
  void chirp(const Command&);
  void frame(const Command&);
  void cfar(const Command&);
  void clutter(const Command&);
  void extended(const Command&);
  void angles(const Command&);
  void ranges(const Command&);
  void check();
  void check_profile(const TiProfile&);
  void check_frame();

  void fail(ErrorCode code, std::string message, std::size_t line = 0) {
    if (!error_) error_ = Error{code, std::move(message), source_, line};
  }
  double value(const Command& command, std::size_t i);
  int whole(const Command& command, std::size_t i);
  unsigned mask(const Command& command, std::size_t i, int bits);

  std::string source_;
  TiConfig config_;
  std::map<int, TiProfile> profiles_;
  std::set<std::string_view> seen_;
  std::optional<Error> error_;
};

double Reader::value(const Command& command, std::size_t i) {
  const auto number = number_of(command.arguments[i]);
  if (!number) {
    fail(ErrorCode::parse,
         std::string(command.name) + ": argument " + std::to_string(i + 1) + ", '" +
             std::string(command.arguments[i]) + "', is not a number",
         command.line);
  }
  return number.value_or(0.0);
}

int Reader::whole(const Command& command, std::size_t i) {
  const double number = value(command, i);
  if (number != std::floor(number) || std::abs(number) > 1e6) {
    fail(ErrorCode::parse,
         std::string(command.name) + ": argument " + std::to_string(i + 1) +
             " is not an integer up to 1000000",
         command.line);
    return 0;
  }
  return static_cast<int>(number);
}

unsigned Reader::mask(const Command& command, std::size_t i, int bits) {
  const int number = whole(command, i);
  if (number < 0 || number >= 1 << bits) {
    fail(ErrorCode::invalid,
         std::string(command.name) + ": mask " + std::to_string(number) + " is out of range",
         command.line);
    return 0;
  }
  return static_cast<unsigned>(number);
}

void Reader::mode(const Command& c) {
  if (whole(c, 0) != 1)
    fail(ErrorCode::unsupported, "dfeDataOutputMode: only frames (1) are supported", c.line);
}

void Reader::channel(const Command& c) {
  config_.rx_mask = mask(c, 0, 4);
  config_.tx_mask = mask(c, 1, 3);
  if (config_.rx_mask == 0 || config_.tx_mask == 0)
    fail(ErrorCode::invalid, "channelCfg: needs a receiver and a transmitter", c.line);
}

void Reader::profile(const Command& c) {
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

void Reader::chirp(const Command& c) {
  const TiChirp chirp{whole(c, 0), whole(c, 1), whole(c, 2), mask(c, 7, 3)};
  if (chirp.first < 0 || chirp.last < chirp.first || chirp.last > 511 || chirp.tx_mask == 0)
    fail(ErrorCode::invalid, "chirpCfg: invalid range of chirps, or no transmitter", c.line);
  config_.chirps.push_back(chirp);
}

void Reader::frame(const Command& c) {
  config_.frame = {whole(c, 0), whole(c, 1), whole(c, 2), whole(c, 3), value(c, 4)};
  const TiFrameTiming& f = config_.frame;
  if (f.first_chirp < 0 || f.last_chirp < f.first_chirp || f.last_chirp > 511 || f.loops < 1 ||
      f.loops > 255 || f.frames < 0 || !(f.period_ms > 0.0))
    fail(ErrorCode::invalid, "frameCfg: invalid chirps, loops or period", c.line);
}

void Reader::cfar(const Command& c) {
  const int direction = whole(c, 1);
  if (direction != 0 && direction != 1)
    return fail(ErrorCode::invalid, "cfarCfg: direction is 0 (range) or 1 (Doppler)", c.line);
  config_.cfar[static_cast<std::size_t>(direction)] = {true, value(c, 7)};
}

void Reader::clutter(const Command& c) { config_.clutter_removal = whole(c, 1) != 0; }

void Reader::extended(const Command& c) { config_.extended_velocity = whole(c, 1) != 0; }

void Reader::angles(const Command& c) {
  config_.min_azimuth = Angle::degrees(value(c, 1));
  config_.max_azimuth = Angle::degrees(value(c, 2));
  config_.min_elevation = Angle::degrees(value(c, 3));
  config_.max_elevation = Angle::degrees(value(c, 4));
}

void Reader::ranges(const Command& c) {
  const int direction = whole(c, 1);
  const double low = value(c, 2), high = value(c, 3);
  if ((direction != 0 && direction != 1) || !(low <= high))
    return fail(ErrorCode::invalid,
                "cfarFovCfg: expected direction 0 or 1, then minimum and maximum", c.line);
  (direction == 0 ? config_.min_range_m : config_.min_speed_mps) = low;
  (direction == 0 ? config_.max_range_m : config_.max_speed_mps) = high;
}

const std::map<std::string_view, Reader::Entry>& Reader::entries() {
  static const std::map<std::string_view, Entry> kEntries = {
      {"dfeDataOutputMode", {1, &Reader::mode}}, {"channelCfg", {2, &Reader::channel}},
      {"profileCfg", {14, &Reader::profile}},    {"chirpCfg", {8, &Reader::chirp}},
      {"frameCfg", {5, &Reader::frame}},         {"cfarCfg", {8, &Reader::cfar}},
      {"clutterRemoval", {2, &Reader::clutter}}, {"extendedMaxVelocity", {2, &Reader::extended}},
      {"aoaFovCfg", {5, &Reader::angles}},       {"cfarFovCfg", {4, &Reader::ranges}}};
  return kEntries;
}

void Reader::take(const Command& command) {
  if (command.name == "advFrameCfg" || command.name == "subFrameCfg")
    return fail(ErrorCode::unsupported, "advanced frames are not supported", command.line);
  const auto entry = entries().find(command.name);
  if (entry == entries().end()) {
    config_.others.emplace_back(command.text);
    return;
  }
  const auto& [min_arguments, handler] = entry->second;
  if (command.arguments.size() < min_arguments) {
    return fail(ErrorCode::parse,
                std::string(command.name) + ": expected at least " + std::to_string(min_arguments) +
                    " arguments, found " + std::to_string(command.arguments.size()),
                command.line);
  }
  seen_.insert(entry->first);
  (this->*handler)(command);
}

/// The chip's limits, and the sampling time within one ramp.
void Reader::check_profile(const TiProfile& p) {
  const double sampling_us = 1e3 * p.samples / p.sample_ksps;
  const auto require = [&](bool good, const char* what) {
    if (!good) fail(ErrorCode::invalid, "profileCfg " + std::to_string(p.id) + ": " + what);
  };
  require(
      (p.start_ghz >= 76.0 && p.start_ghz <= 81.0) || (p.start_ghz >= 57.0 && p.start_ghz <= 64.0),
      "start frequency outside 57 to 64 and 76 to 81 GHz");
  require(p.samples >= 2 && p.samples <= 8192, "number of samples out of range");
  require(p.sample_ksps > 0.0 && p.sample_ksps <= 37500.0, "sampling rate out of range");
  require(p.idle_us >= 0.0 && p.adc_start_us >= 0.0, "negative time");
  require(p.slope_mhz_per_us > 0.0 && p.slope_mhz_per_us <= 300.0, "slope out of range");
  require(p.adc_start_us + sampling_us <= p.ramp_end_us, "sampling ends after the ramp");
  const double end_ghz = p.start_ghz + 1e-3 * p.slope_mhz_per_us * p.ramp_end_us;
  require(end_ghz <= (p.start_ghz < 70.0 ? 64.0 : 81.0) + 1e-6, "ramp leaves the band");
}

/// The chirps of the frame exist, have one profile, and fit into the period.
void Reader::check_frame() {
  const TiFrameTiming& f = config_.frame;
  std::optional<int> profile;
  for (int i = f.first_chirp; i <= f.last_chirp; ++i) {
    const auto chirp = std::find_if(config_.chirps.begin(), config_.chirps.end(),
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

void Reader::check() {
  for (const std::string_view name : {"channelCfg", "profileCfg", "chirpCfg", "frameCfg"})
    if (!seen_.contains(name)) fail(ErrorCode::not_found, "missing command " + std::string(name));
  for (const auto& [id, profile] : profiles_) check_profile(profile);
  if (!error_) check_frame();
}

Result<TiConfig> Reader::read(std::string_view text) {
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

}  // namespace

Result<TiConfig> parse_ti_config(std::string_view text, const std::string& source) {
  return Reader(source).read(text);
}

}  // namespace wayfare::decode
