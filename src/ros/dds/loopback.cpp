#include "ros/dds/loopback.hpp"

#include <dirent.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cstdlib>
#include <memory>

namespace wayfare::ros::dds {
namespace {

/// Whether it is a UDP socket on a port of the domain, for all addresses.
bool receives(int fd, unsigned domain) {
  int type = 0;
  socklen_t size = sizeof type;
  if (::getsockopt(fd, SOL_SOCKET, SO_TYPE, &type, &size) != 0 || type != SOCK_DGRAM) return false;
  sockaddr_in address{};
  size = sizeof address;
  if (::getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size) != 0 ||
      address.sin_family != AF_INET || address.sin_addr.s_addr != htonl(INADDR_ANY))
    return false;
  constexpr unsigned kFirst = 7400, kOfEach = 250;  // RTPS 2.3, 9.6.1.1
  const unsigned port = ntohs(address.sin_port), first = kFirst + kOfEach * domain;
  return port >= first && port < first + kOfEach;
}

}  // namespace

bool bind_to_loopback(unsigned domain) {
  const std::unique_ptr<DIR, int (*)(DIR*)> files(::opendir("/proc/self/fd"), ::closedir);
  bool found = false, bound = true;
  // NOLINTNEXTLINE(concurrency-mt-unsafe): of a stream of its own
  while (const dirent* file = files ? ::readdir(files.get()) : nullptr) {
    const int fd = std::atoi(file->d_name);
    if (!receives(fd, domain)) continue;
    constexpr char kDevice[] = "lo";
    found = true;
    bound &= ::setsockopt(fd, SOL_SOCKET, SO_BINDTODEVICE, kDevice, sizeof kDevice) == 0;
  }
  return found && bound;
}

}  // namespace wayfare::ros::dds
