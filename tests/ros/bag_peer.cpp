#include "bag_peer.hpp"

#include <rosbag/bag.h>
#include <rosbag/view.h>

namespace peer {

std::vector<Message> read_bag(const std::string& path) {
  rosbag::Bag bag(path, rosbag::bagmode::Read);
  std::vector<Message> all;
  for (const rosbag::MessageInstance& m : rosbag::View(bag)) {
    Message out{m.getTopic(),    m.getDataType(), m.getMD5Sum(), std::string(m.size(), '\0'),
                m.getTime().sec, m.getTime().nsec};
    ros::serialization::OStream stream(reinterpret_cast<std::uint8_t*>(&out.data[0]), m.size());
    m.write(stream);
    all.push_back(out);
  }
  return all;
}

void copy_bag(const std::string& from, const std::string& to, const std::string& compression) {
  rosbag::Bag in(from, rosbag::bagmode::Read), out(to, rosbag::bagmode::Write);
  out.setCompression(compression == "lz4"   ? rosbag::compression::LZ4
                     : compression == "bz2" ? rosbag::compression::BZ2
                                            : rosbag::compression::Uncompressed);
  out.setChunkThreshold(100 * 1024);
  for (const rosbag::MessageInstance& m : rosbag::View(in))
    out.write(m.getTopic(), m.getTime(), m, m.getConnectionHeader());
  out.close();
}

}  // namespace peer
