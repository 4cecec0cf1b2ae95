#include "ros/dds/cdr_type.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <new>

#include <dds/ddsi/ddsi_serdata.h>
#include <dds/ddsi/ddsi_sertype.h>
#include <dds/ddsi/q_radmin.h>

namespace wayfare::ros::dds {
namespace {

/// Bytes with the four of the encoding; allocated to a multiple of four, as RTPS reads them.
struct Serialised : ddsi_serdata {
  Serialised(const ddsi_sertype* of, ddsi_serdata_kind as, std::size_t n)
      : size(n), bytes(new (std::nothrow) char[(n + 3) / 4 * 4]{}) {
    ddsi_serdata_init(this, of, as);
  }
  std::size_t size;
  std::unique_ptr<char[]> bytes;
};

const Serialised& of(const ddsi_serdata* data) { return *static_cast<const Serialised*>(data); }

/// Null without memory.
std::unique_ptr<Serialised> allocate(const ddsi_sertype* type, ddsi_serdata_kind kind,
                                     std::size_t size) {
  std::unique_ptr<Serialised> data(new (std::nothrow) Serialised(type, kind, size));
  if (data && !data->bytes) data.reset();
  return data;
}

ddsi_serdata* from_fragments(const ddsi_sertype* type, ddsi_serdata_kind kind,
                             const nn_rdata* fragment, std::size_t size) {
  auto data = allocate(type, kind, size);
  if (!data) return nullptr;
  // Fragments may overlap.
  std::size_t end = 0;
  for (; fragment != nullptr; fragment = fragment->nextfrag) {
    const std::size_t until = std::min<std::size_t>(fragment->maxp1, size);
    if (until <= end) continue;
    if (fragment->min > end) return nullptr;
    const auto* payload =
        NN_RMSG_PAYLOADOFF(fragment->rmsg, NN_RDATA_PAYLOAD_OFF(fragment)) - fragment->min;
    std::memcpy(data->bytes.get() + end, payload + end, until - end);
    end = until;
  }
  return end == size ? data.release() : nullptr;
}

ddsi_serdata* from_buffers(const ddsi_sertype* type, ddsi_serdata_kind kind,
                           ddsrt_msg_iovlen_t buffers, const ddsrt_iovec_t* buffer,
                           std::size_t size) {
  auto data = allocate(type, kind, size);
  if (!data) return nullptr;
  std::size_t end = 0;
  for (ddsrt_msg_iovlen_t i = 0; i < buffers && end < size; ++i) {
    const std::size_t n = std::min<std::size_t>(buffer[i].iov_len, size - end);
    std::memcpy(data->bytes.get() + end, buffer[i].iov_base, n);
    end += n;
  }
  return end == size ? data.release() : nullptr;
}

ddsi_serdata* from_message(const ddsi_sertype* type, ddsi_serdata_kind kind, const void* sample) {
  const auto& message = *static_cast<const std::string_view*>(sample);
  const ddsrt_iovec_t buffer{const_cast<char*>(message.data()), message.size()};
  return from_buffers(type, kind, 1, &buffer, message.size());
}

// The types of ROS have no keys: a sample with a key alone is empty.
ddsi_serdata* from_key(const ddsi_sertype* type, const ddsi_keyhash*) {
  return allocate(type, SDK_KEY, 0).release();
}

ddsi_serdata* without_type(const ddsi_serdata* data) {
  ddsi_serdata* key = allocate(data->type, SDK_KEY, 0).release();
  if (key != nullptr) key->type = nullptr;
  return key;
}

void copy_out(const ddsi_serdata* data, std::size_t begin, std::size_t n, void* to) {
  std::memcpy(to, of(data).bytes.get() + begin, n);
}

ddsi_serdata* borrow(const ddsi_serdata* data, std::size_t begin, std::size_t n,
                     ddsrt_iovec_t* to) {
  to->iov_base = of(data).bytes.get() + begin;
  to->iov_len = n;
  return ddsi_serdata_ref(data);
}

const ddsi_serdata_ops kDataOperations = [] {
  ddsi_serdata_ops o{};
  o.eqkey = [](const ddsi_serdata*, const ddsi_serdata*) { return true; };
  o.get_size = [](const ddsi_serdata* d) { return static_cast<std::uint32_t>(of(d).size); };
  o.from_ser = from_fragments;
  o.from_ser_iov = from_buffers;
  o.from_keyhash = from_key;
  o.from_sample = from_message;
  o.to_ser = copy_out;
  o.to_ser_ref = borrow;
  o.to_ser_unref = [](ddsi_serdata* d, const ddsrt_iovec_t*) { ddsi_serdata_unref(d); };
  // Only dds_takecdr is used, which gives the bytes themselves.
  o.to_sample = [](const ddsi_serdata*, void*, void**, void*) { return false; };
  o.to_untyped = without_type;
  o.untyped_to_sample = [](const ddsi_sertype*, const ddsi_serdata*, void*, void**, void*) {
    return false;
  };
  o.free = [](ddsi_serdata* d) { delete static_cast<Serialised*>(d); };
  o.print = [](const ddsi_sertype*, const ddsi_serdata* d, char* to, std::size_t n) {
    return static_cast<std::size_t>(std::snprintf(to, n, "%zu bytes", of(d).size));
  };
  o.get_keyhash = [](const ddsi_serdata*, ddsi_keyhash* to, bool) { *to = {}; };
  return o;
}();

const ddsi_sertype_ops kTypeOperations = [] {
  ddsi_sertype_ops o{};
  o.version = ddsi_sertype_v0;
  o.free = [](ddsi_sertype* type) {
    ddsi_sertype_fini(type);
    delete type;
  };
  o.zero_samples = [](const ddsi_sertype*, void*, std::size_t) {};
  o.realloc_samples = [](void**, const ddsi_sertype*, void*, std::size_t, std::size_t) {};
  o.free_samples = [](const ddsi_sertype*, void**, std::size_t, dds_free_op_t) {};
  o.equal = [](const ddsi_sertype*, const ddsi_sertype*) { return true; };  // their names are
  o.hash = [](const ddsi_sertype*) { return std::uint32_t{0}; };
  return o;
}();

}  // namespace

ddsi_sertype* cdr_type(const std::string& dds_name) {
  auto* type = new (std::nothrow) ddsi_sertype{};
  if (type == nullptr) return nullptr;
  ddsi_sertype_init_flags(type, dds_name.c_str(), &kTypeOperations, &kDataOperations,
                          DDSI_SERTYPE_FLAG_TOPICKIND_NO_KEY);
  type->allowed_data_representation = DDS_DATA_REPRESENTATION_FLAG_XCDR1;
  return type;
}

void Unreference::operator()(ddsi_serdata* data) const { ddsi_serdata_unref(data); }

std::string_view bytes_of(const ddsi_serdata& data) {
  return {of(&data).bytes.get(), of(&data).size};
}

}  // namespace wayfare::ros::dds
