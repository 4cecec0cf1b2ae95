// Runs a fuzz target without libFuzzer, so that the tests of every build have a short run of it:
// short_run TIMES PREFIX_BYTE|- [SEED FILE...]. Seeds, or pieces of them, are damaged reproducibly;
// the target aborts on a finding.

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include <wayfare/core/random.hpp>
#include <wayfare/io/text_file.hpp>

// NOLINTNEXTLINE(readability-redundant-declaration): libFuzzer has no header
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

using namespace wayfare;
using Bytes = std::vector<std::uint8_t>;

constexpr std::size_t kPiece = 6000;

Bytes piece_of(const Bytes& seed, Rng& rng) {
  if (seed.empty()) {
    Bytes noise(rng.below(500));
    for (auto& byte : noise) byte = static_cast<std::uint8_t>(rng());
    return noise;
  }
  const std::size_t at = rng.below(2) == 0 ? 0 : rng.below(seed.size());
  const auto begin = seed.begin() + static_cast<long>(at);
  return {begin, begin + static_cast<long>(std::min(kPiece, seed.size() - at))};
}

void damage(Bytes& bytes, Rng& rng) {
  for (auto k = rng.below(6); k > 0 && !bytes.empty(); --k) {
    const auto at = bytes.begin() + static_cast<long>(rng.below(bytes.size()));
    switch (rng.below(4)) {
      case 0:
        *at = static_cast<std::uint8_t>(rng());
        break;
      case 1:
        bytes.erase(at, at + static_cast<long>(std::min<std::uint64_t>(
                                 1 + rng.below(30), static_cast<std::uint64_t>(bytes.end() - at))));
        break;
      case 2:
        bytes.insert(at, 1 + rng.below(8), rng.below(2) == 0 ? std::uint8_t{0xFF} : *at);
        break;
      default: {
        const Bytes copy(at, at + std::min<long>(bytes.end() - at, 40));
        bytes.insert(bytes.begin() + static_cast<long>(rng.below(bytes.size())), copy.begin(),
                     copy.end());
      }
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return 2;
  std::vector<Bytes> seeds(1);  // the first is random
  for (int i = 3; i < argc; ++i) {
    const auto content = io::read_file(argv[i]);
    if (content) seeds.emplace_back(content->bytes.begin(), content->bytes.end());
  }
  Rng rng(1);
  const int times = std::atoi(argv[1]);
  for (int i = 0; i < times; ++i) {
    Bytes input = piece_of(seeds[static_cast<std::size_t>(i) % seeds.size()], rng);
    if (i >= static_cast<int>(seeds.size())) damage(input, rng);
    if (argv[2][0] != '-')
      input.insert(input.begin(), static_cast<std::uint8_t>(std::atoi(argv[2])));
    LLVMFuzzerTestOneInput(input.data(), input.size());
  }
  std::printf("%d inputs of %zu seeds\n", times, seeds.size() - 1);
  return 0;
}
