#include "server.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <mutex>
#include <set>
#include <thread>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "access.hpp"
#include "live_feed.hpp"
#include "live_link.hpp"
#include "recording_view.hpp"
#include "secret_file.hpp"

#include "bounded_server.hpp"

namespace wayfare::examples {
namespace {

using httplib::Request;
using httplib::Response;
using nlohmann::json;

/// One of a limited number of slots, during its lifetime; false if all are taken.
class Slot {
 public:
  Slot(std::atomic<std::size_t>& taken, std::size_t most) : taken_(taken) {
    has_ = ++taken_ <= most;
    if (!has_) --taken_;
  }
  Slot(const Slot&) = delete;
  Slot& operator=(const Slot&) = delete;
  ~Slot() {
    if (has_) --taken_;
  }
  explicit operator bool() const { return has_; }

 private:
  std::atomic<std::size_t>& taken_;
  bool has_ = false;
};

void refuse(Response& response, int status, const std::string& why) {
  response.status = status;
  response.set_content(why + "\n", "text/plain");
}

double number_of(const Request& request, const char* name, double otherwise) {
  if (!request.has_param(name)) return otherwise;
  const double value = std::strtod(request.get_param_value(name).c_str(), nullptr);
  return value >= 0.0 && value < 1e9 ? value : otherwise;
}

AccessOptions access_options(const MonitorOptions& o, bool open_reading) {
  return {o.token, !open_reading, o.host_names, o.requests_per_s};
}

ConnectionLimits connection_limits(const MonitorOptions& o) {
  ConnectionLimits limits;
  limits.connections = o.connections;
  limits.per_address = std::max<std::size_t>(o.connections / 4, 1);
  limits.request_time = std::chrono::milliseconds(static_cast<long>(1000.0 * o.request_s));
  return limits;
}

/// All values of a parameter that may be repeated, at most a hundred.
std::vector<std::string> values_of(const Request& request, const char* name) {
  std::vector<std::string> values;
  const std::size_t n = std::min<std::size_t>(request.get_param_value_count(name), 100);
  for (std::size_t i = 0; i < n; ++i) values.push_back(request.get_param_value(name, i));
  return values;
}

std::set<std::string> topics_of(const Request& request) {
  const auto topics = values_of(request, "topic");
  return {topics.begin(), topics.end()};
}

Interval interval_of(const Request& request) {
  return {number_of(request, "from", 0.0), number_of(request, "until", Interval::kAll)};
}

/// A file name with the topic.
std::string file_name(std::string topic, const char* end) {
  for (char& c : topic)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  topic.erase(0, topic.find_first_not_of('_'));
  return (topic.empty() ? "recording" : topic.substr(0, 80)) + end;
}

}  // namespace

struct MonitorServer::Impl {
  Impl(MonitorOptions given, bool open)
      : options(std::move(given)),
        open_reading(open),
        access(access_options(options, open_reading)),
        server(connection_limits(options)) {}
  ~Impl() {
    quit = true;
    if (feed) feed->stop();
    server.stop();
    if (thread.joinable()) thread.join();
  }

  bool admit(const Request& request, Response& response) {
    const Refusal refusal =
        access.check({request.get_header_value("Host"), request.get_header_value("Origin"),
                      request.get_header_value("Authorization"), request.get_param_value("token")},
                     request.path == "/api/command");
    if (refusal.status != 0) refuse(response, refusal.status, refusal.why);
    return refusal.status == 0;
  }

  /// The recording of the options, else that of the live logger.
  [[nodiscard]] std::shared_ptr<const RecordingView> view() {
    const std::lock_guard lock(view_mutex);
    std::string path = options.recording;
    if (path.empty() && live) {
      std::uint64_t seen = 0;
      const json status =
          json::parse(live->wait(seen, std::chrono::milliseconds(0)), nullptr, false);
      if (status.is_object() && status.contains("file") && status["file"].is_string())
        path = status["file"].get<std::string>();
    }
    if (path.empty()) return nullptr;
    if (!shown || shown->path() != path) shown = std::make_shared<const RecordingView>(path);
    return shown;
  }

  using Answer = std::function<Result<std::string>(const RecordingView&, const Request&)>;

  /// Queries that read much of a recording do not take the slots of the others.
  void query(const char* path, const char* type, Answer answer, bool is_long = false) {
    server.Get(path, [this, type, answer = std::move(answer), is_long](const Request& request,
                                                                       Response& response) {
      const Slot slot(is_long ? long_queries : queries, options.queries);
      if (!slot) return refuse(response, 503, "busy; try again");
      const auto recording = view();
      if (!recording) return refuse(response, 404, "there is no recording yet");
      const auto found = answer(*recording, request);
      if (!found) return refuse(response, 404, found.error().to_string());
      response.set_content(*found, type);
    });
  }

  using Export =
      std::function<Result<void>(const RecordingView&, const Request&, const PieceSink&)>;

  void exported(const char* path, const char* type, const char* end, Export write) {
    server.Get(path, [this, type, end, write = std::move(write)](const Request& request,
                                                                 Response& response) {
      const auto recording = view();
      const std::string topic = request.get_param_value("topic");
      if (!recording) return refuse(response, 404, "there is no recording yet");
      response.set_header("Content-Disposition",
                          "attachment; filename=\"" + file_name(topic, end) + "\"");
      response.set_chunked_content_provider(
          type, [this, recording, request, write](std::size_t, httplib::DataSink& sink) {
            const Slot slot(long_queries, options.queries);
            if (!slot) return false;
            const auto done = write(*recording, request, [&](std::string_view piece) {
              return !quit && sink.write(piece.data(), piece.size());
            });
            if (done) sink.done();
            return done.has_value();  // false breaks off the response
          });
    });
  }

  void route_recording() {
    constexpr const char* kJson = "application/json";
    query("/api/contents", kJson,
          [](const RecordingView& v, const Request&) { return v.contents(); });
    query(
        "/api/series", kJson,
        [](const RecordingView& v, const Request& r) {
          return v.series(r.get_param_value("topic"), values_of(r, "field"), interval_of(r),
                          static_cast<std::size_t>(std::min(number_of(r, "n", 2000.0), 20000.0)));
        },
        true);
    query("/api/range", "application/x-ndjson", [](const RecordingView& v, const Request& r) {
      return v.range(topics_of(r), interval_of(r), r.has_param("before"));
    });
    query("/api/message", kJson, [](const RecordingView& v, const Request& r) {
      return v.message(r.get_param_value("topic"), number_of(r, "t", 0.0));
    });
    query(
        "/api/walk", kJson,
        [](const RecordingView& v, const Request& r) { return v.walk(r.get_param_value("topic")); },
        true);
    query(
        "/api/map.png", "image/png",
        [this](const RecordingView& v, const Request&) { return v.map_png(options.map_s); }, true);
    exported("/export.csv", "text/csv", ".csv",
             [](const RecordingView& v, const Request& r, const PieceSink& sink) {
               return v.csv(r.get_param_value("topic"), interval_of(r), sink);
             });
    exported("/export.mcap", "application/octet-stream", ".mcap",
             [](const RecordingView& v, const Request& r, const PieceSink& sink) {
               std::set<std::string> topics = topics_of(r);
               topics.erase("");
               return v.mcap(topics, interval_of(r), sink);
             });
  }

  void route_live() {
    server.Get("/api/events", [this](const Request& request, Response& response) {
      if (!feed) return refuse(response, 404, "there is no live logger");
      auto slot = std::make_shared<Slot>(listeners, options.listeners);
      if (!*slot) return refuse(response, 503, "too many listeners");
      response.set_header("Cache-Control", "no-store");
      response.set_chunked_content_provider(
          "text/event-stream", [this, slot, listener = LiveFeed::Listener{topics_of(request)}](
                                   std::size_t, httplib::DataSink& sink) mutable {
            const std::string events = feed->wait(listener, std::chrono::seconds(1));
            return !quit && (events.empty() || sink.write(events.data(), events.size()));
          });
    });
    server.Post("/api/command", [this](const Request& request, Response& response) {
      // Forms of other sites cannot send this header.
      if (request.get_header_value("X-Wayfare").empty())
        return refuse(response, 403, "the header X-Wayfare is missing");
      if (!live) return refuse(response, 404, "there is no live logger");
      const auto command = request.body.size() == 1
                               ? logger::command_of(static_cast<std::uint8_t>(request.body[0]))
                               : std::nullopt;
      if (!command) return refuse(response, 400, "expected one of B, S, T, C");
      if (!live->send(*command)) return refuse(response, 502, "the logger is not connected");
      response.set_content("sent\n", "text/plain");
    });
  }

  void set_up() {
    server.set_pre_routing_handler([this](const Request& request, Response& response) {
      return admit(request, response) ? httplib::Server::HandlerResponse::Unhandled
                                      : httplib::Server::HandlerResponse::Handled;
    });
    server.set_default_headers({{"X-Content-Type-Options", "nosniff"},
                                {"Referrer-Policy", "no-referrer"},
                                {"Content-Security-Policy",
                                 "default-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
                                 "frame-ancestors 'none'"}});
    server.set_payload_max_length(256);
    server.Get("/", [](const Request&, Response& response) {
      response.set_content(monitor_page(), "text/html; charset=utf-8");
    });
    server.Get("/api/about", [this](const Request&, Response& response) {
      response.set_content(
          json({{"live", live != nullptr}, {"cell_m", RecordingView::map_cell_m()}}).dump(),
          "application/json");
    });
    route_recording();
    route_live();
  }

  const MonitorOptions options;
  const bool open_reading;  // only commands need the token
  Access access;
  std::atomic<bool> quit{false};
  std::atomic<std::size_t> queries{0}, long_queries{0}, listeners{0};
  std::unique_ptr<LiveLink> live;
  std::unique_ptr<LiveFeed> feed;
  std::mutex view_mutex;
  std::shared_ptr<const RecordingView> shown;
  BoundedServer server;
  SecretFile token_file;
  int port = 0;
  std::thread thread;
};

MonitorServer::MonitorServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
MonitorServer::~MonitorServer() = default;

Result<std::unique_ptr<MonitorServer>> MonitorServer::start(MonitorOptions options) {
  if (options.recording.empty() && options.live.empty())
    return Error{ErrorCode::invalid, "a monitor needs a recording or a live logger"};
  if (!options.recording.empty())
    if (const auto file = io::McapReader::open(options.recording); !file) return file.error();
  const bool open_reading = options.token.empty() && is_loopback(options.host);
  if (options.token.empty() && (!open_reading || !options.live.empty()))
    options.token = random_token();
  auto impl = std::make_unique<Impl>(std::move(options), open_reading);
  const MonitorOptions& o = impl->options;
  if (!o.live.empty()) {
    impl->live = std::make_unique<LiveLink>(o.live, o.baud);
    impl->feed = std::make_unique<LiveFeed>(*impl->live);
  }
  impl->set_up();
  if (o.port == 0) {
    impl->port = impl->server.bind_to_any_port(o.host);
  } else {
    impl->port = impl->server.bind_to_port(o.host, o.port) ? o.port : -1;
  }
  if (impl->port <= 0)
    return Error{ErrorCode::io, "cannot listen on port " + std::to_string(o.port), o.host};
  if (!o.token_file.empty() && !o.token.empty()) {
    auto file = SecretFile::create(o.token_file, o.token);
    if (!file) return file.error();
    impl->token_file = std::move(*file);
  }
  impl->server.set_backlog(512);
  impl->thread = std::thread([raw = impl.get()] { raw->server.listen_after_bind(); });
  while (!impl->server.is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  return std::unique_ptr<MonitorServer>(new MonitorServer(std::move(impl)));
}

int MonitorServer::port() const { return impl_->port; }
const std::string& MonitorServer::token() const { return impl_->options.token; }
std::string MonitorServer::url() const {
  const MonitorOptions& o = impl_->options;
  // What follows # stays in the browser.
  return "http://" + o.host + ":" + std::to_string(impl_->port) + "/" +
         (o.token.empty() ? "" : (impl_->open_reading ? "#token=" : "?token=") + o.token);
}

}  // namespace wayfare::examples
