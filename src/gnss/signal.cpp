#include <wayfare/gnss/ephemerides.hpp>

namespace wayfare {

const char* name_of(GnssSystem system) {
  constexpr const char* kNames[] = {"GPS", "GLONASS", "Galileo", "BeiDou"};
  return kNames[index_of(system)];
}

std::optional<GnssSystem> system_of(char letter) {
  for (const GnssSystem system : kAllGnssSystems)
    if (letter_of(system) == letter) return system;
  return std::nullopt;
}

std::string to_string(SatelliteId satellite) {
  std::string text(1, letter_of(satellite.system));
  if (satellite.number < 10) text += '0';
  return text += std::to_string(satellite.number);
}

std::optional<SatelliteId> parse_satellite(std::string_view text) {
  char letter = 'G';
  if (text.size() == 3) {
    if (text[0] != ' ') letter = text[0];
    text.remove_prefix(1);
  }
  const std::optional<GnssSystem> system = system_of(letter);
  if (!system || text.size() != 2) return std::nullopt;
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  if ((text[0] != ' ' && !digit(text[0])) || !digit(text[1])) return std::nullopt;
  const int number = (text[0] == ' ' ? 0 : text[0] - '0') * 10 + (text[1] - '0');
  if (number == 0) return std::nullopt;
  return SatelliteId{*system, static_cast<std::uint8_t>(number)};
}

std::optional<double> carrier_hz(GnssSystem system, char band, int glonass_channel) {
  const auto pick = [&](std::string_view bands, std::initializer_list<double> carriers) {
    const std::size_t at = bands.find(band);
    return at == bands.npos ? std::nullopt : std::optional<double>(carriers.begin()[at]);
  };
  switch (system) {
    case GnssSystem::gps:
      return pick("125", {carrier::kL1, carrier::kL2, carrier::kL5});
    case GnssSystem::galileo:
      return pick("15786",
                  {carrier::kE1, carrier::kE5a, carrier::kE5b, carrier::kE5, carrier::kE6});
    case GnssSystem::beidou:
      return pick("21576",
                  {carrier::kB1I, carrier::kB1C, carrier::kL5, carrier::kB2I, carrier::kB3I});
    case GnssSystem::glonass:
      break;
  }
  if (band == '1') return carrier::kGlonassL1 + glonass_channel * carrier::kGlonassL1Step;
  if (band == '2') return carrier::kGlonassL2 + glonass_channel * carrier::kGlonassL2Step;
  return std::nullopt;
}

}  // namespace wayfare
