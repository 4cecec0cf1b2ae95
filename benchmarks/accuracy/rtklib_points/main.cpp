// Single points of RTKLIB's library, to compare with.

#include <cstdio>
#include <ctime>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include <wayfare/io/observations.hpp>
#include <wayfare/io/rinex.hpp>
#include <wayfare/io/text_file.hpp>

#include "support/program_files.hpp"

// Debian ships the library without its header: these are its functions as of version 2.4.3 b34.
// The options are read by the library itself, so that their layout does not matter.
extern "C" {

struct gtime_t {
  std::time_t time;
  double sec;
};
struct opt_t {
  const char* name;
  int format;
  void* variable;
  const char* comment;
};
extern opt_t sysopts[];
void resetsysopts();
int loadopts(const char* file, opt_t* options);
void getsysopts(void* processing, void* solution, void* files);
int postpos(gtime_t begin, gtime_t end, double interval, double unit, const void* processing,
            const void* solution, const void* files, char** inputs, int count, char* output,
            const char* rover, const char* base);

// Progress callbacks required by the library.
int showmsg(const char*, ...) { return 0; }
void settspan(gtime_t, gtime_t) {}
void settime(gtime_t) {}
}

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Options : OutputArguments {
  std::string obs, raim = "off";
  std::vector<std::string> nav;
  double elevation_mask_deg = 15.0;
};

/// Larger than the library's structures.
struct alignas(64) Block {
  char bytes[1 << 20] = {};
};

std::string settings(const Options& o) {
  return "pos1-posmode=single\npos1-navsys=33\npos1-elmask=" +
         std::to_string(o.elevation_mask_deg) +
         "\npos1-ionoopt=brdc\npos1-tropopt=saas\npos1-posopt5=" + o.raim + "\n";
}

/// The library does not say what is wrong with a file.
Result<void> check(const Options& o) {
  if (const auto obs = io::read_observations(o.obs); !obs) return obs.error();
  for (const std::string& path : o.nav)
    if (const auto nav = io::read_rinex_navigation(path); !nav) return nav.error();
  return {};
}

/// A file in the folder of results that is removed in the end.
struct Temporary {
  std::string path;
  ~Temporary() {
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
  }
};

Result<void> run(const Options& o) {
  if (auto good = check(o); !good) return good;
  if (auto ready = o.prepare({"rtklib.pos"}); !ready) return ready;
  const std::string out = o.path("rtklib.pos");
  // The library reads plain files only.
  const Temporary obs{out + ".obs"}, config{out + ".conf"};
  const auto file = io::read_file(o.obs);
  if (!file) return file.error();
  if (auto done = first_error({io::write_file(obs.path, file->bytes, o.write()),
                               io::write_file(config.path, settings(o), o.write())});
      !done)
    return done;
  const auto processing = std::make_unique<Block>(), solution = std::make_unique<Block>(),
             files = std::make_unique<Block>();
  resetsysopts();
  if (loadopts(config.path.c_str(), sysopts) == 0)
    return Error{ErrorCode::invalid, "RTKLIB does not take the options", config.path};
  getsysopts(processing.get(), solution.get(), files.get());
  std::vector<std::string> paths = {obs.path};
  paths.insert(paths.end(), o.nav.begin(), o.nav.end());
  std::vector<char*> inputs;
  for (std::string& path : paths) inputs.push_back(path.data());
  std::string output = out;
  if (postpos({}, {}, 0.0, 0.0, processing.get(), solution.get(), files.get(), inputs.data(),
              static_cast<int>(inputs.size()), output.data(), "", "") != 0)
    return Error{ErrorCode::degenerate, "RTKLIB gives no solution", o.obs};
  if (!o.quiet) std::printf("positions      %s\n", out.c_str());
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app(
      "Single points by RTKLIB's library from GPS and BeiDou observations and broadcast messages, "
      "with and without its RAIM, for spp --peer.");
  Options options;
  app.add_file("--obs", options.obs, "observations, RINEX, plain or gzip").required();
  app.add_file("--nav", options.nav, "RINEX navigation files").required().expected(1, 64);
  app.add_option("--raim", options.raim, "its exclusion of one faulty satellite, on or off")
      .one_of({"on", "off"})
      .show_default();
  app.add_number("--elevation-mask", options.elevation_mask_deg, 0.0, 90.0,
                 "smallest elevation of the satellites used, deg");
  app.add_option("--out", options.out, "folder for rtklib.pos").required().shown_as("DIR");
  add_force_and_quiet(app, options);
  app.example("--obs rover.obs --nav brdc.nav --raim on --out out/raim",
              "positions in out/raim/rtklib.pos");
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("rtklib_points", run(options));
}
