#include "lfdcore/hardware/scip_lidar.hpp"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <vector>

#include "lfdcore/error.hpp"
#include "scip_session.hpp"

namespace lfdcore {
namespace {

constexpr double connect_time = 1.0;  // [s]
constexpr int rates[] = {115200, 19200, 57600, 500000};
constexpr int jumps = 3;  // so many times in a row that cannot be are no damage but another clock

struct Address {
  std::string host;  // or path
  int port = 0;      // 0: a serial port
};

Address parse_address(const std::string& text) {
  if (text.find('/') != std::string::npos) return {text, 0};
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos) return {text, ScipLidar::port};
  int port = 0;
  const char *begin = text.data() + colon + 1, *end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(begin, end, port);
  if (error != std::errc() || rest != end || port < 1 || port > 65535)
    throw std::invalid_argument("the port of '" + text + "' must be a number of 1 to 65535");
  return {text.substr(0, colon), port};
}

std::vector<int> rates_from(int first) {
  std::vector<int> all{first};
  std::copy_if(std::begin(rates), std::end(rates), std::back_inserter(all), [=](int rate) { return rate != first; });
  return all;
}

std::string list(const std::vector<int>& numbers) {
  std::string text;
  for (const int number : numbers) text += (text.empty() ? "" : ", ") + std::to_string(number);
  return text;
}

}  // namespace

class ScipLidar::Worker {
 public:
  Worker(const std::string& address, const ScipConfig& config);
  ~Worker() { close(); }

  void close();
  std::optional<TimedScan> newest() const;
  std::optional<TimedScan> wait_newer(std::uint64_t sequence, double patience) const;

  template <typename T>
  T read(T Worker::* value) const {
    const std::lock_guard lock(mutex_);
    return this->*value;
  }

  ScipStatistics statistics;
  std::string fault;
  ScipParameters parameters;

 private:
  void run();
  void restart();
  void measure();
  void start(const std::vector<int>& bauds);
  DeviceStream open(int baud) const;
  void hold(std::unique_ptr<ScipSession> session);
  bool greets(const std::vector<int>& bauds, std::string& heard);
  void listen();
  void take(std::string_view text);
  void take_scan(const ScipReply& reply, double received);
  void publish(TimedScan scan, std::uint64_t lost);
  void count_damage(std::uint64_t times);
  void report(const std::string& what);
  bool pause();

  const std::string text_;
  const Address address_;
  const ScipConfig config_;
  int baud_;  // that it last answered at
  std::atomic<bool> stopping_ = false;
  std::mutex closing_;
  mutable std::mutex mutex_;  // of all that more than one thread uses
  mutable std::condition_variable changed_;
  std::unique_ptr<ScipSession> session_;
  std::optional<TimedScan> newest_;
  std::vector<std::uint32_t> distances_;
  double heard_ = 0, patience_ = 0;  // [s] when it last gave a scan, and for how long it may give none
  int jumps_ = 0;
  std::uint64_t strange_ = 0;
  std::thread thread_;
};

ScipLidar::Worker::Worker(const std::string& address, const ScipConfig& config)
    : text_(address), address_(parse_address(address)), config_(config), baud_(config.baud) {
  start(address_.port == 0 ? rates_from(baud_) : std::vector<int>{baud_});
  thread_ = std::thread([this] { run(); });
}

void ScipLidar::Worker::close() {
  const std::lock_guard only_one(closing_);
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    if (session_) session_->interrupt();
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

std::optional<TimedScan> ScipLidar::Worker::newest() const {
  const std::lock_guard lock(mutex_);
  return newest_;
}

std::optional<TimedScan> ScipLidar::Worker::wait_newer(std::uint64_t sequence, double patience) const {
  require_between("patience", patience, 0, 1e9, "s");
  std::unique_lock lock(mutex_);
  const auto newer = [&] { return newest_ && newest_->sequence > sequence; };
  changed_.wait_for(lock, std::chrono::duration<double>(patience), [&] { return newer() || stopping_; });
  return newer() ? newest_ : std::nullopt;
}

void ScipLidar::Worker::run() {
  do {
    try {
      if (!session_) restart();
      measure();
    } catch (const std::exception& error) {  // also where the system is short of something
      report(error.what());
      if (!stopping_) hold(nullptr);  // a port that is still open would come back under another name
    }
  } while (pause());
  if (session_) session_->quit();
  hold(nullptr);
  report(text_ + ": closed");
}

void ScipLidar::Worker::restart() {
  start({baud_});
  const std::lock_guard lock(mutex_);
  ++statistics.reconnects;
}

// Until the device is lost (DeviceError) or close() is called.
void ScipLidar::Worker::measure() {
  heard_ = host_now();
  patience_ = first_scan;
  strange_ = jumps_ = 0;
  while (!stopping_) listen();
}

// Opens the device, and brings it to measure.
void ScipLidar::Worker::start(const std::vector<int>& bauds) {
  std::string heard;
  if (!greets(bauds, heard)) {
    const bool serial = address_.port == 0;
    throw DeviceError(text_ + ": no SCIP 2.0 device answers" + (serial ? " at " + list(bauds) + " baud" : "") + ", " +
                      heard + "; check its power, " +
                      (serial ? "that it is on this port and what its rate is"
                              : "that this is its port and that no other program is connected to it"));
  }
  session_->start();
  const std::lock_guard lock(mutex_);
  parameters = session_->parameters();
}

bool ScipLidar::Worker::greets(const std::vector<int>& bauds, std::string& heard) {
  for (const int baud : bauds) {
    hold(nullptr);  // before the port is opened again
    hold(std::make_unique<ScipSession>(open(baud), stopping_));
    baud_ = baud;
    if (session_->greet()) return true;
    heard = session_->heard();
  }
  return false;
}

DeviceStream ScipLidar::Worker::open(int baud) const {
  if (address_.port == 0) return DeviceStream::open_serial(address_.host, baud);
  return DeviceStream::connect_tcp(address_.host, static_cast<std::uint16_t>(address_.port), connect_time);
}

void ScipLidar::Worker::hold(std::unique_ptr<ScipSession> session) {
  const std::lock_guard lock(mutex_);
  session_.swap(session);
}

void ScipLidar::Worker::listen() {
  const auto text = session_->next_measurement(std::max(0.0, heard_ + patience_ - host_now()));
  if (const std::uint64_t strange = session_->strange(); strange != strange_) {
    count_damage(strange - strange_);
    strange_ = strange;
  }
  if (text) take(*text);
  if (host_now() > heard_ + patience_)
    throw DeviceError(text_ + ": no scan for more than " + std::to_string(static_cast<int>(patience_)) +
                      " s; check its power and its cable");
}

void ScipLidar::Worker::take(std::string_view text) {
  const double received = host_now();
  try {
    const ScipReply reply = parse_scip_reply(text);
    if (reply.status == "99") return take_scan(reply, received);
    if (reply.status == "00") return;  // of the command
    const std::string what = text_ + ": no scans, " + ScipSession::said(reply.echo, reply.status);
    const bool goes_on = reply.status == "98" || (reply.status >= "21" && reply.status <= "49");
    if (!goes_on) throw DeviceError(what);
    report(what);
  } catch (const DataError&) {
    count_damage(1);
  }
}

void ScipLidar::Worker::take_scan(const ScipReply& reply, double received) {
  const ScipParameters& said = session_->parameters();
  const std::uint32_t ticks = parse_scip_time(reply);
  parse_scip_distances(reply, 3, said.beams(), distances_);
  const auto stamp = session_->clock().host_time(ticks, received);
  if (!stamp) {
    if (++jumps_ < jumps) return count_damage(1);
    throw DeviceError(text_ + ": its clock jumped; it was reset, or its scans come too late");
  }
  jumps_ = 0;
  const double scans = 1e-3 * static_cast<double>(session_->clock().interval()) / said.scan_period();
  publish({scan_from_scip(distances_, said, config_.upside_down), *stamp, 0},
          static_cast<std::uint64_t>(std::max(0.0, scans - 0.5)));
  heard_ = received;
  patience_ = silence;
}

void ScipLidar::Worker::publish(TimedScan scan, std::uint64_t lost) {
  {
    const std::lock_guard lock(mutex_);
    scan.sequence = ++statistics.scans;
    statistics.lost += lost;
    fault.clear();
    newest_ = std::move(scan);
  }
  changed_.notify_all();
}

void ScipLidar::Worker::count_damage(std::uint64_t times) {
  const std::lock_guard lock(mutex_);
  statistics.damaged += times;
}

void ScipLidar::Worker::report(const std::string& what) {
  const std::lock_guard lock(mutex_);
  fault = what;
}

// -> whether to go on.
bool ScipLidar::Worker::pause() {
  std::unique_lock lock(mutex_);
  return !changed_.wait_for(lock, std::chrono::duration<double>(retry), [this] { return stopping_.load(); });
}

ScipLidar::ScipLidar(const std::string& address, const ScipConfig& config)
    : worker_(std::make_unique<Worker>(address, config)) {}
ScipLidar::~ScipLidar() = default;

void ScipLidar::close() { worker_->close(); }
std::optional<TimedScan> ScipLidar::newest() const { return worker_->newest(); }
std::optional<TimedScan> ScipLidar::wait_newer(std::uint64_t sequence, double patience) const {
  return worker_->wait_newer(sequence, patience);
}
ScipStatistics ScipLidar::statistics() const { return worker_->read(&Worker::statistics); }
std::string ScipLidar::fault() const { return worker_->read(&Worker::fault); }
std::string ScipLidar::model() const { return worker_->read(&Worker::parameters).model; }
double ScipLidar::scan_period() const { return worker_->read(&Worker::parameters).scan_period(); }

}  // namespace lfdcore
