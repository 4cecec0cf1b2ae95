#pragma once

// Small RINEX files, built by columns.

#include <cstdio>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/gnss/gps_time.hpp>

namespace wayfare::testing {

inline std::string rinex_header(std::string content, const std::string& label) {
  content.resize(60, ' ');
  return content + label + "\n";
}

inline std::string rinex_value(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%14.3f", value);
  return text;
}

/// Numbers of a navigation line, 19 columns each with Fortran's exponent.
inline std::string rinex_numbers(const std::vector<double>& values) {
  std::string line;
  for (const double value : values) {
    char text[32];
    std::snprintf(text, sizeof text, "%19.12E", value);
    line += text;
  }
  for (char& c : line)
    if (c == 'E') c = 'D';
  return line;
}

/// GPS, GLONASS and BeiDou, with Doppler; header of version 3.
inline std::string rinex_3_header() {
  std::string text =
      rinex_header("     3.04           OBSERVATION DATA    M: MIXED", "RINEX VERSION / TYPE");
  text += rinex_header("ROVER", "MARKER NAME");
  text += rinex_header(" -2419215.8865  5385498.5603  2405403.6314", "APPROX POSITION XYZ");
  text += rinex_header("        1.5000        0.0000        0.2500", "ANTENNA: DELTA H/E/N");
  text += rinex_header("G    8 C1C L1C D1C S1C C2W L2W D2W S2W", "SYS / # / OBS TYPES");
  text += rinex_header("R    4 C1C L1C D1C S1C", "SYS / # / OBS TYPES");
  text += rinex_header("C    2 C2I S2I", "SYS / # / OBS TYPES");
  text += rinex_header("  2019     4    28    12    44   33.9970000     GPS", "TIME OF FIRST OBS");
  text += rinex_header("  2 R01  1 R02 -4", "GLONASS SLOT / FRQ #");
  text += rinex_header("    18", "LEAP SECONDS");
  return text += rinex_header("", "END OF HEADER");
}

inline std::string rinex_3_epoch(const std::string& time, const std::string& satellites) {
  std::size_t lines = 0;
  for (const char c : satellites) lines += c == '\n' ? 1 : 0;
  char count[32];
  std::snprintf(count, sizeof count, "  0%3zu\n", lines);
  std::string text("> ");
  text += time;
  text += count;
  return text += satellites;
}

/// One satellite with C1C L1C D1C S1C.
inline std::string rinex_3_satellite(const std::string& name, double range, double doppler,
                                     double cn0) {
  std::string text = name;
  text += rinex_value(range);
  text.append(18, ' ');
  text += rinex_value(doppler);
  text += "  ";
  text += rinex_value(cn0);
  return text += '\n';
}

inline std::string rinex_3_observations() {
  std::string first = rinex_3_satellite("G 2", 21600712.022, 445.146, 27.0);
  first += rinex_3_satellite("R02", 20672491.775, -811.224, 26.0);
  first += "G08";  // only its second band
  first.append(64, ' ');
  first += rinex_value(22846861.832);
  first += "\nC11";
  first += rinex_value(22238239.302);
  first += "  ";
  first += rinex_value(20.0);
  first += "\nJ01";
  first += rinex_value(38000000.0);
  first += '\n';
  std::string text = rinex_3_header();
  text += rinex_3_epoch("2019 04 28 12 44 33.9970000", first);
  text += rinex_3_epoch("2019 04 28 12 44 34.9970000",
                        rinex_3_satellite("G02", 21600627.834, 445.563, 27.0));
  return text += rinex_3_epoch("2019 04 28 12 44 35.9970000",
                               rinex_3_satellite("G02", 21600543.834, 445.9, 28.0));
}

/// Six types (two lines a satellite) and fourteen satellites (two lines of names).
inline std::string rinex_2_observations() {
  std::string text =
      rinex_header("     2.11           OBSERVATION DATA    M (MIXED)", "RINEX VERSION / TYPE");
  text += rinex_header("     6    L1    C1    D1    S1    P2    L2", "# / TYPES OF OBSERV");
  text += rinex_header("  2006     1     1     0     0    0.0000000     GPS", "TIME OF FIRST OBS");
  text += rinex_header("", "END OF HEADER");
  for (int second = 0; second < 3; ++second) {
    char line[64];
    std::snprintf(line, sizeof line, " 06  1  1  0  0%11.7f  0%3d", second + 0.25, 14);
    text += line;
    for (int i = 1; i <= 14; ++i) {
      if (i == 13) text.append(1, '\n').append(32, ' ');
      std::snprintf(line, sizeof line, "%c%2d", i == 14 ? 'R' : i % 2 != 0 ? 'G' : ' ', i);
      text += line;
    }
    text += "\n";
    for (int i = 1; i <= 14; ++i) {
      for (const double v : {1.1e8 + i, 2.1e7 + i, 100.0 * i, 40.0 + i, 2.1e7 + 2 * i}) {
        text += rinex_value(v);
        text += "  ";
      }
      text += '\n';
      text += rinex_value(9e7 + i);
      text += '\n';
    }
  }
  return text;
}

/// A line of blanks and numbers.
inline std::string rinex_line(std::size_t blanks, const std::vector<double>& values) {
  std::string line(blanks, ' ');
  line += rinex_numbers(values);
  return line += '\n';
}

/// The first line of a message.
inline std::string rinex_message(std::string satellite_and_date, const std::vector<double>& clock) {
  satellite_and_date += rinex_numbers(clock);
  return satellite_and_date += '\n';
}

/// `last_delay` is GPS's issue of data, or BeiDou's second group delay.
inline std::string rinex_keplerian_lines(double of_week, double week, double health,
                                         double last_delay = 61.0, std::size_t blanks = 4) {
  std::string text;
  text += rinex_line(blanks, {61.0, -37.75, 4.938e-09, 0.4172});
  text += rinex_line(blanks, {-1.9e-06, 1.89e-02, 4.88e-06, 5153.694378});
  text += rinex_line(blanks, {of_week, -2.98e-07, -2.424, -9.3e-09});
  text += rinex_line(blanks, {0.9544, 287.8, -1.746, -8.712e-09});
  text += rinex_line(blanks, {-1.796e-10, 1.0, week, 0.0});
  text += rinex_line(blanks, {2.0, health, -2.05e-08, last_delay});
  return text += rinex_line(blanks, {of_week - 7200.0});
}

inline std::string rinex_glonass_lines(std::size_t blanks, double channel) {
  std::string text;
  text += rinex_line(blanks, {12000.0, 1.5, 1.8e-9, 0.0});
  text += rinex_line(blanks, {-15000.0, 2.0, -9e-10, channel});
  return text += rinex_line(blanks, {16700.0, 0.7, -2.8e-9, 0.0});
}

/// Two GPS messages, one of BeiDou, one of GLONASS, one of SBAS that is skipped.
inline std::string rinex_3_navigation() {
  std::string text =
      rinex_header("     3.04           N: GNSS NAV DATA    M: MIXED", "RINEX VERSION / TYPE");
  text += rinex_header("GPSA   9.3132D-09  1.4901D-08 -5.9605D-08 -1.1921D-07", "IONOSPHERIC CORR");
  text += rinex_header("GPSB   8.8064D+04  4.9152D+04 -1.3107D+05 -3.2768D+05", "IONOSPHERIC CORR");
  text += rinex_header("    18    18  1929     7", "LEAP SECONDS");
  text += rinex_header("", "END OF HEADER");
  text += rinex_message("G02 2019 04 28 12 00 00", {-1.99e-04, -9.32e-12, 0.0});
  text += rinex_keplerian_lines(43200.0, 2051.0, 0.0);
  text += rinex_message("C11 2019 04 28 12 00 00", {-1.99e-04, -9.32e-12, 0.0});
  text += rinex_keplerian_lines(43200.0, 695.0, 0.0, 1.2e-08);
  text += rinex_message("R02 2019 04 28 12 15 00", {5.5e-05, 1.8e-12, 43200.0});
  text += rinex_glonass_lines(4, -4.0);
  text += rinex_message("S33 2019 04 28 12 15 12", {7.1e-08, 0.0, 43200.0});
  text += rinex_glonass_lines(4, 2.0);
  text += rinex_message("G02 2019 04 28 14 00 00", {-1.98e-04, -9.32e-12, 0.0});
  return text += rinex_keplerian_lines(50400.0, 2051.0, 1.0);
}

inline std::string rinex_2_navigation() {
  std::string text = rinex_header("     2.11           N: GPS NAV DATA", "RINEX VERSION / TYPE");
  text += rinex_header("     .9313D-08   .1490D-07  -.5961D-07  -.1192D-06", "ION ALPHA");
  text += rinex_header("     .8806D+05   .4915D+05  -.1311D+06  -.3277D+06", "ION BETA");
  text += rinex_header("", "END OF HEADER");
  text += rinex_message(" 2 19  4 28 12  0  0.0", {-1.99e-04, -9.32e-12, 0.0});
  return text += rinex_keplerian_lines(43200.0, 2051.0, 0.0, 61.0, 3);
}

/// The text with the first occurrence of `from` replaced.
inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, text.npos) << from;
  return text.replace(at, from.size(), to);
}

/// A time of the samples' day.
inline Time<GpsClock> gps(int hour, int minute, Duration of_minute) {
  return *gps_from_civil({2019, 4, 28, hour, minute, of_minute});
}

}  // namespace wayfare::testing
