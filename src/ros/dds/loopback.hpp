#pragma once

// Sockets that nothing but this computer reaches.

namespace wayfare::ros::dds {

/// Binds the process's UDP sockets on the ports of a domain to the loopback device: Cyclone binds
/// those that receive to all addresses, whatever interfaces it is given. False if the system
/// refuses one of them, or there is none.
[[nodiscard]] bool bind_to_loopback(unsigned domain);

}  // namespace wayfare::ros::dds
