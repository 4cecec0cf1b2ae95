#pragma once

// A DDS type whose samples are CDR bytes: nothing is serialised a second time, and a type needs a
// name only.

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

struct ddsi_serdata;
struct ddsi_sertype;

namespace wayfare::ros::dds {

/// For dds_create_topic_sertype, which owns it; null without memory. dds_write takes a
/// std::string_view of a serialised message as its sample.
[[nodiscard]] ddsi_sertype* cdr_type(const std::string& dds_name);

/// Releases a reference.
struct Unreference {
  void operator()(ddsi_serdata* data) const;
};
using SerialisedPtr = std::unique_ptr<ddsi_serdata, Unreference>;

/// The bytes of what dds_takecdr gave, of a reader of such a type.
[[nodiscard]] std::string_view bytes_of(const ddsi_serdata& data);

}  // namespace wayfare::ros::dds
