#include "links.hpp"

#include <wayfare/decode/ti_decoder.hpp>

bool reads_chirps() {
  const auto bad = wayfare::decode::parse_ti_config("profileCfg 0 77\n", "chirps");
  return !bad && bad.error().line == 1;
}
