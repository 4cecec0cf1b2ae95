#pragma once

// Several devices in one recording: one thread per device that only reads and stamps, one thread
// that writes, and between them a bounded queue that bridges delays of the disk. It is controlled
// over a line that may lose or corrupt bytes: a command is one byte, and the next status line,
// which has a checksum, shows its effect.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <wayfare/core/detail/owned.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/logger/device_decoder.hpp>
#include <wayfare/logger/serial_port.hpp>

namespace wayfare::logger {

/// Every command may be repeated without harm.
enum class Command : char {
  begin = 'B',      ///< start recording
  stop = 'S',       ///< stop recording
  terminate = 'T',  ///< stop and end the program
  check = 'C',      ///< send a status line now
};

/// Nothing for bytes that are no command.
[[nodiscard]] std::optional<Command> command_of(std::uint8_t byte);

/// `json`, '*', its CRC-32 in eight hexadecimal digits, end of line.
[[nodiscard]] std::string status_line(std::string_view json);
/// The JSON of such a line (with or without its end), if the checksum is right.
[[nodiscard]] std::optional<std::string_view> status_of_line(std::string_view line);

/// One device and its line.
struct SensorOptions {
  DeviceDescription device;           ///< its name and what decodes it
  std::string port;                   ///< path of the serial line
  ModemLine dtr = ModemLine::keep;    ///< set when the port is opened
  std::vector<std::uint8_t> request;  ///< bytes sent once the port is open, such as a scan request
  /// Of an RPLIDAR without a `request`: the scan mode in which it is started by its protocol (see
  /// decode::RplidarStart), or "listen" to send nothing.
  std::string mode = "typical";
  std::optional<SE3d> mounting = {};  ///< pose in the frame `base_frame`, if it is known
  /// Command port of a TI radar, at 115 200 bit/s: its configuration is sent whenever the port is
  /// opened. Empty: the radar is configured otherwise.
  std::string command_port = {};
};

/// Devices, files, intervals and remote control of a Logger.
struct LoggerOptions {
  std::vector<SensorOptions> sensors;    ///< at least one, with different names
  std::string folder = ".";              ///< of the recordings; none is overwritten
  std::string prefix = "recording";      ///< of their names
  std::string base_frame = "base_link";  ///< on which the sensors are mounted
  /// Interval of writing to the operating system: the greatest loss if the program is killed.
  Duration flush_every = std::chrono::milliseconds(100);
  /// Interval of flushing to the disk: the greatest loss in a power failure, besides the disk's
  /// own.
  Duration sync_every = std::chrono::seconds(1);
  Duration status_every = std::chrono::seconds(1);  ///< interval of the status lines
  /// Time of bytes that become no measurement until the sensor's status has a warning.
  Duration warn_after = std::chrono::seconds(3);
  /// A file of this size is followed by another, up to a chunk of a megabyte or `flush_every`
  /// later; 0: never. Each can be read alone.
  std::uint64_t rotate_bytes = 0;
  Duration rotate_every = Duration(0);  ///< the same for a file of this duration
  /// The status warns where the disk is full within this time at the present rate.
  Duration warn_disk = std::chrono::minutes(10);
  /// Waiting for the disk; beyond, data is dropped.
  std::size_t queue_bytes = std::size_t{64} << 20;
  std::string control_port = {};  ///< serial line with remote control; empty: none
  int control_baud = 57600;       ///< its rate, bit/s
  /// Unix socket with the same protocol; empty: none. Up to 16 clients at once, others are closed,
  /// as is one whose unread status lines fill its buffer.
  std::string control_socket = {};
  /// Creates the output of a recording; empty: a file. Neither it nor its sinks may call `begin` or
  /// destroy the logger.
  std::function<Result<std::unique_ptr<io::ByteSink>>(const std::string& path)> open_sink = {};
  /// The computer's clock, UTC; empty: the system's. Called by several threads.
  std::function<LogTime()> wall_clock = {};
};

/// What the logger does now.
enum class LoggerState {
  idle,        ///< no recording
  starting,    ///< the recording's file is being created
  recording,   ///< data is being written
  stopping,    ///< what was read is being written, and the file closed
  failed,      ///< the disk failed; `begin` tries again
  terminated,  ///< no command is accepted
};
/// In words, as in the status.
[[nodiscard]] const char* name_of(LoggerState state);

/// What a device does now.
enum class SensorState {
  waiting,    ///< its port cannot be opened
  silent,     ///< no bytes for 2 s
  receiving,  ///< bytes within the last 2 s
};
/// In words, as in the status.
[[nodiscard]] const char* name_of(SensorState state);

/// Counts and condition of one device.
struct SensorStatus {
  std::string name;                          ///< of the sensor
  SensorState state = SensorState::waiting;  ///< of its line
  std::uint64_t bytes = 0;                   ///< read since the start
  std::uint64_t recorded_bytes = 0;  ///< of them written to this recording's file, in whole records
  /// Records that are not in this recording: the queue had no room, or the disk failed. Records are
  /// written in chunks: of one that the disk does not take as a whole, all are dropped. Those read
  /// once the state says `failed` belong to no recording.
  std::uint64_t dropped = 0;
  double bytes_per_s = 0.0;     ///< over the last status interval
  double messages_per_s = 0.0;  ///< decoded, over the last status interval
  DecodingStatus decoding;      ///< results of its decoder
  std::string note;  ///< reason for waiting, limitations of the line, what an RPLIDAR identified as
  std::string warning;  ///< bytes become no measurements, and why; no scan of an RPLIDAR
};

/// File, counts and error are those of the last recording that was begun, even if its file could
/// not be created.
struct LoggerStatus {
  LoggerState state = LoggerState::idle;  ///< what it does now
  LogTime time;                           ///< of this status
  std::string file;                       ///< path of the recording, of its last file
  std::uint32_t files = 0;                ///< of this recording
  double seconds = 0.0;                   ///< of this recording
  std::uint64_t written = 0;              ///< bytes of its files
  std::uint64_t disk_free = 0;            ///< bytes left on the disk of the recordings
  std::size_t queued = 0,                 ///< bytes waiting for the disk
      queue_peak = 0;                     ///< the most so far
  std::uint64_t dropped = 0;              ///< records, of all sensors
  std::string error;                      ///< reason why recording failed
  std::string warning;                    ///< the disk is nearly full; no next file can be created
  std::vector<SensorStatus> sensors;      ///< in the order of the options
};

/// The status as the JSON of status lines, the recording's status channel and the monitor. The
/// sensors' latest measurements are left out where they would make it longer than 3 kB.
[[nodiscard]] std::string to_json(const LoggerStatus& status);

/// Runs from `start` on; the destructor stops recording, waits until all that was queued is written
/// and ends all threads. After `wait_until_stopped` the status says whether the disk failed.
///
/// All but the destructor may be called from any thread, and act as if one after the other: a
/// recording that is stopped while its file is being created is ended once that is done.
///
/// Times are nanoseconds of UTC since 1970 by the computer's clock at the start of the logger, and
/// by its monotonic clock from then on, so that they never jump; /logger/clock has the computer's
/// clock where a file begins and where that clock was set. For each sensor the recording has the
/// channel /NAME/raw with its bytes and their times of reading, and the channels of decoded
/// messages; it has /logger/status and, if a sensor's mounting is known, /tf_static.
class Logger {
 public:
  /// Errors: no sensor, two with one name, an unknown kind, a control port that cannot be opened, a
  /// control socket on which another logger listens.
  [[nodiscard]] static Result<std::unique_ptr<Logger>> start(LoggerOptions options);

  /// Error: the recording cannot be created; the one before is still being written; the logger is
  /// terminated. Does nothing while one is being made; after one that failed it begins another.
  Result<void> begin();
  /// Ends the recording once all data read so far is written.
  void stop();
  /// Stops, and accepts no further command.
  void terminate();

  /// A snapshot of the counts and states.
  [[nodiscard]] LoggerStatus status() const;
  /// Waits until recording has ended; false after the timeout (of a year at most).
  bool wait_until_stopped(Duration timeout);

 private:
  struct Impl;
  explicit Logger(detail::Owned<Impl> impl);

  detail::Owned<Impl> impl_;
};

}  // namespace wayfare::logger
