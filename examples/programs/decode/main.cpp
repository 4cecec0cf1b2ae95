// Decodes a capture of a device's port, plain or gzip, to a table.

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
  std::string device, capture, config;
  bool csv = false;
  RplidarTableOptions rplidar;
  decode::MtLegacyLayout layout;
};

const std::map<std::string, decode::RplidarResponse> kAnswers = {
    {"descriptor", decode::RplidarResponse::none},
    {"node", decode::RplidarResponse::node},
    {"express", decode::RplidarResponse::express},
    {"ultra", decode::RplidarResponse::ultra},
    {"dense", decode::RplidarResponse::dense}};

void describe(CommandLine& app, Arguments& a) {
  app.add_option("device", a.device,
                 "ti (AWR1843 and its family), rplidar, xsens, ubx (u-blox) or nmea")
      .required()
      .one_of({"ti", "awr1843", "rplidar", "xsens", "ubx", "nmea"});
  app.add_option("file", a.capture, "the capture, plain or gzip").shown_as("FILE").required();
  app.add_flag("--csv", a.csv, "comma-separated values, the only format so far");
  app.add_option("--out", a.out, "file to write; by default standard output").shown_as("FILE");
  add_force_and_quiet(app, a);
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

Result<Table> table_of(const Arguments& a, decode::Bytes capture) {
  if (a.device == "rplidar") return rplidar_table(capture, a.rplidar);
  if (a.device == "xsens") return xsens_table(capture, a.layout);
  if (a.device == "ubx") return ubx_table(capture);
  if (a.device == "nmea") return nmea_table(capture);
  const auto step = doppler_step(a);
  if (!step) return step.error();
  return ti_table(capture, *step);
}

void print_summary(const Table& table) {
  const decode::DecoderStatistics& s = table.statistics;
  std::fprintf(stderr, "%s\n", table.contents.c_str());
  std::fprintf(
      stderr, "%llu bytes, %llu of them outside frames, %llu wrong checksums, %llu malformed\n",
      static_cast<unsigned long long>(s.bytes), static_cast<unsigned long long>(s.skipped_bytes),
      static_cast<unsigned long long>(s.checksum_failures),
      static_cast<unsigned long long>(s.malformed));
}

Result<void> run(const Arguments& a) {
  const auto content = io::read_file(a.capture);
  if (!content) return content.error();
  if (content->damage) std::fprintf(stderr, "skipped: %s\n", content->damage->to_string().c_str());
  const auto* begin = reinterpret_cast<const std::uint8_t*>(content->bytes.data());
  const auto table = table_of(a, {begin, content->bytes.size()});
  if (!table) return table.error();
  if (!a.quiet) print_summary(*table);
  if (table->statistics.frames == 0)
    return Error{ErrorCode::parse, "contains no frame of this device", a.capture};
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
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("decode", run(arguments));
}
