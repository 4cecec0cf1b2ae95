// Decodes a capture of a device's port, plain or gzip, or a logger's recording, to a table.

#include <cstdio>
#include <map>
#include <string>

#include <wayfare/decode/ti_decoder.hpp>
#include <wayfare/io/text_file.hpp>

#include "support/program_files.hpp"
#include "tables.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Arguments : OutputArguments {
  std::string device, capture, config, topic, table;
  bool csv = false;
  RplidarTableOptions rplidar;
  decode::MtLegacyLayout layout;
};

const std::map<std::string, decode::RplidarResponse> kAnswers = {
    {"descriptor", decode::RplidarResponse::none},
    {"node", decode::RplidarResponse::node},
    {"express", decode::RplidarResponse::express},
    {"hq", decode::RplidarResponse::hq},
    {"ultra", decode::RplidarResponse::ultra},
    {"dense", decode::RplidarResponse::dense},
    {"ultra_dense", decode::RplidarResponse::ultra_dense}};

const std::map<std::string, TiTable> kTiTables = {
    {"points", TiTable::points},           {"frames", TiTable::frames},
    {"profiles", TiTable::profiles},       {"doppler_map", TiTable::doppler_map},
    {"azimuth_map", TiTable::azimuth_map}, {"targets", TiTable::targets}};
const std::map<std::string, XsensTable> kXsensTables = {{"samples", XsensTable::samples},
                                                        {"gnss", XsensTable::gnss},
                                                        {"satellites", XsensTable::satellites},
                                                        {"raw", XsensTable::raw}};

void describe(CommandLine& app, Arguments& a) {
  app.add_option("device", a.device,
                 "ti (AWR1843 and its family), rplidar, xsens, ubx (u-blox) or nmea")
      .required()
      .one_of({"ti", "awr1843", "rplidar", "xsens", "ubx", "nmea"});
  app.add_option("file", a.capture, "the capture, plain or gzip, or a logger's recording (.mcap)")
      .shown_as("FILE")
      .required();
  app.add_flag("--csv", a.csv, "comma-separated values, the only format so far");
  app.add_option("--out", a.out, "file to write; by default standard output").shown_as("FILE");
  add_force_and_quiet(app, a);
  app.add_option("--topic", a.topic,
                 "of the unit, in a recording (.mcap) of several devices of its kind: its bytes, "
                 "such as /radar/raw")
      .shown_as("TOPIC");
  app.add_option("--table", a.table,
                 "ti: points, frames (also empty ones: statistics, temperatures), profiles, "
                 "doppler_map, azimuth_map or targets; xsens: samples, gnss, satellites or raw. By "
                 "default the first")
      .one_of({"points", "frames", "profiles", "doppler_map", "azimuth_map", "targets", "samples",
               "gnss", "satellites", "raw"});
  app.add_option("--config", a.config, "ti: chirp configuration (.cfg), for speeds before SDK 3");
  app.add_choice("--inside", a.rplidar.inside, kAnswers,
                 "rplidar: answer in which the capture begins");
  app.add_number("--baud", a.rplidar.baud, 1200.0, 1e8,
                 "rplidar: rate of the serial line, for the times");
  app.add_option("--sample-us", a.rplidar.sample_us,
                 "rplidar: time per sample; by default from the capture, else 500 or 250")
      .range(1.0, 1e5);
  app.add_option("--output-mode", a.layout.mode, "xsens: of MTData messages, as set on the device");
  app.add_option("--output-settings", a.layout.settings,
                 "xsens: of MTData messages, as set on the device");
}

Result<std::optional<double>> doppler_step(const Arguments& a) {
  if (a.config.empty()) return std::optional<double>();
  const auto text = io::read_file(a.config);
  if (!text) return text.error();
  const auto config = decode::parse_ti_config(text->bytes, a.config);
  if (!config) return config.error();
  return std::optional(decode::limits_of(*config).speed_step_mps);
}

/// The table chosen among a device's; the first of them if none was.
template <class T>
Result<T> chosen(const Arguments& a, const std::map<std::string, T>& tables) {
  if (a.table.empty()) return T{};
  const auto it = tables.find(a.table);
  if (it != tables.end()) return it->second;
  return Error{ErrorCode::invalid, "--table: " + a.device + " has no table " + a.table};
}

Result<Table> table_of(const Arguments& a, const Capture& capture) {
  const auto ti = chosen(a, kTiTables);
  const auto xsens = chosen(a, kXsensTables);
  if (a.device == "xsens") {
    if (!xsens) return xsens.error();
    return *xsens == XsensTable::samples ? xsens_table(capture.view(), a.layout)
                                         : xsens_other_table(capture.view(), *xsens);
  }
  if (a.device == "ti" || a.device == "awr1843") {
    const auto step = doppler_step(a);
    if (!step) return step.error();
    if (!ti) return ti.error();
    return *ti == TiTable::points ? ti_table(capture.view(), *step)
                                  : ti_other_table(capture.view(), *ti);
  }
  if (!a.table.empty())
    return Error{ErrorCode::invalid, "--table: " + a.device + " has one table only"};
  if (a.device == "rplidar") return rplidar_table(capture, a.rplidar);
  return a.device == "ubx" ? ubx_table(capture.view()) : nmea_table(capture.view());
}

/// A device's kind in a logger's recording.
std::string kind_of(const std::string& device) {
  if (device == "ti" || device == "awr1843") return "ti_mmwave";
  return device == "rplidar" || device == "xsens" ? device : "raw";
}

void print_summary(const Table& table) {
  const decode::DecoderStatistics& s = table.statistics;
  std::fprintf(stderr, "%s\n", table.contents.c_str());
  std::fprintf(
      stderr, "%llu bytes, %llu of them outside frames, %llu wrong checksums, %llu malformed\n",
      static_cast<unsigned long long>(s.bytes), static_cast<unsigned long long>(s.skipped_bytes),
      static_cast<unsigned long long>(s.checksum_failures),
      static_cast<unsigned long long>(s.malformed));
  if (!table.refused.empty()) std::fprintf(stderr, "refused: %s\n", table.refused.c_str());
}

Result<void> run(const Arguments& a) {
  std::string damage;
  const auto capture = read_capture(a.capture, a.topic, kind_of(a.device), damage);
  if (!capture) return capture.error();
  if (!damage.empty()) std::fprintf(stderr, "skipped: %s\n", damage.c_str());
  const auto table = table_of(a, *capture);
  if (!table) return table.error();
  if (!a.quiet) print_summary(*table);
  if (table->statistics.frames == 0)
    return Error{
        ErrorCode::parse,
        "contains no frame of this device" + (table->refused.empty() ? "" : "; " + table->refused),
        a.capture};
  if (!a.out.empty()) return io::write_file(a.out, table->csv, a.write());
  if (std::fwrite(table->csv.data(), 1, table->csv.size(), stdout) != table->csv.size() ||
      std::fflush(stdout) != 0)
    return Error{ErrorCode::io, "could not be written", "standard output"};
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app(
      "Decode a capture of a device's port to a table with one line per measurement and a header "
      "of "
      "columns and units. Counts of decoded and skipped data are printed on standard error.");
  Arguments arguments;
  describe(app, arguments);
  app.example("xsens unit.bin --csv", "the readings of an Xsens unit on standard output");
  app.example("ubx rover.ubx --csv --out rover.csv",
              "positions, ranges and subframes of a u-blox receiver");
  app.example("ti radar.bin --config radar.cfg --csv --out points.csv",
              "the points of a TI mmWave radar");
  app.example("ti walk.mcap --table frames --csv",
              "statistics and temperatures of each frame of a radar in a logger's recording");
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("decode", run(arguments));
}
