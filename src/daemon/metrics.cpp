#include "daemon/metrics.h"

#include <prometheus/collectable.h>
#include <prometheus/exposer.h>
#include <prometheus/metric_family.h>
#include <prometheus/text_serializer.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <utility>

#include "core/clock.h"
#include "core/output_file.h"
#include "core/repeated_cause.h"
#include "daemon/shared.h"

namespace chequer {
namespace {

/// So many are answered at a time; others wait for one of these.
constexpr const char* kConnections = "8";
/// A request that does not come whole within that time holds up none behind it for longer. A page is asked for within
/// this host.
constexpr const char* kRequestTimeoutMs = "1000";

using prometheus::ClientMetric;
using prometheus::MetricFamily;
using prometheus::MetricType;

/// Adds metrics one by one, families in the order they are first named.
class Families {
 public:
  explicit Families(const std::string& camera) : camera_(camera) {}

  void Counter(const char* name, const char* help, double value, std::vector<ClientMetric::Label> labels = {}) {
    Add(name, help, MetricType::Counter, std::move(labels)).counter.value = value;
  }
  void Gauge(const char* name, const char* help, double value, std::vector<ClientMetric::Label> labels = {}) {
    Add(name, help, MetricType::Gauge, std::move(labels)).gauge.value = value;
  }
  std::vector<MetricFamily> Take() { return std::move(families_); }

 private:
  ClientMetric& Add(const char* name, const char* help, MetricType type, std::vector<ClientMetric::Label> labels) {
    auto family =
        std::find_if(families_.begin(), families_.end(), [&](const auto& known) { return known.name == name; });
    if (family == families_.end()) family = families_.insert(families_.end(), MetricFamily{name, help, type, {}});
    ClientMetric& metric = family->metric.emplace_back();
    metric.label = std::move(labels);
    metric.label.push_back({"camera", camera_});
    return metric;
  }

  std::string camera_;
  std::vector<MetricFamily> families_;
};

template <typename Duration>
double Seconds(Duration time) {
  return std::chrono::duration<double>(time).count();
}

void AddLatencies(const StatusMessage& status, Families& families) {
  constexpr const char* kName = "chequer_latency_seconds";
  constexpr const char* kHelp =
      "Time frames took in a stage of the pipeline over the last second; total is from capture to publishing";
  for (const StageLatency& stage : status.stages) {
    if (stage.frames == 0) continue;
    families.Gauge(kName, kHelp, Seconds(stage.median), {{"stage", stage.stage}, {"quantile", "0.5"}});
    families.Gauge(kName, kHelp, Seconds(stage.p99), {{"stage", stage.stage}, {"quantile", "0.99"}});
    families.Gauge(kName, kHelp, Seconds(stage.worst), {{"stage", stage.stage}, {"quantile", "1"}});
  }
}

void AddCounts(const StatusMessage& status, const MetricTotals& totals, Families& families) {
  const auto number = [](std::uint64_t count) { return static_cast<double>(count); };
  families.Counter("chequer_frames_captured_total", "Usable frames that came from the camera",
                   number(status.frames_captured));
  families.Counter("chequer_frames_published_total", "Frames whose poses were published",
                   number(status.frames_published));
  for (const NamedCount& drop : status.drops)
    families.Counter("chequer_frames_dropped_total", "Frames that were lost, by reason", number(drop.count),
                     {{"reason", drop.name}});
  families.Counter("chequer_messages_total", "Messages handed to LCM", number(status.publisher.sent),
                   {{"result", "sent"}});
  families.Counter("chequer_messages_total", "Messages handed to LCM", number(status.publisher.failed),
                   {{"result", "failed"}});
  for (const NamedCount& count : totals.detections)
    families.Counter("chequer_detections_total", "What the detector saw and refused", number(count.count),
                     {{"what", count.name}});
}

}  // namespace

void MetricTotals::Add(const StatusMessage& status) {
  for (const NamedCount& count : status.detections) {
    auto total = std::find_if(detections.begin(), detections.end(),
                              [&](const NamedCount& known) { return known.name == count.name; });
    if (total == detections.end()) total = detections.insert(detections.end(), {count.name, 0});
    total->count += count.count;
  }
}

std::vector<MetricFamily> MetricFamilies(const StatusMessage& status, const MetricTotals& totals) {
  Families families(status.camera);
  families.Gauge("chequer_info", "1; the version is a label", 1, {{"version", status.version}});
  families.Gauge("chequer_uptime_seconds", "Time since the daemon started", Seconds(status.uptime));
  families.Gauge("chequer_camera_running", "1 while the camera is open, else 0",
                 status.camera_state == CameraState::kRunning ? 1 : 0);
  families.Gauge("chequer_publisher_ready", "1 while LCM takes messages, else 0",
                 status.publisher.state == PublisherState::kReady ? 1 : 0);
  families.Gauge("chequer_capture_rate_hertz", "Frames captured a second, over the last second",
                 status.capture_rate_hz);
  families.Gauge("chequer_publish_rate_hertz", "Frames published a second, over the last second",
                 status.publish_rate_hz);
  families.Gauge("chequer_markers", "Markers a frame, mean over the last second", status.markers_mean);
  AddCounts(status, totals, families);
  AddLatencies(status, families);
  return families.Take();
}

std::string MetricsText(const StatusMessage& status, const MetricTotals& totals) {
  return prometheus::TextSerializer().Serialize(MetricFamilies(status, totals));
}

struct Metrics::Impl final : prometheus::Collectable {
  struct Figures {
    std::optional<StatusMessage> status;
    MetricTotals totals;
  };

  std::filesystem::path file;
  Shared<Figures> figures;
  RepeatedCause file_trouble;
  std::optional<prometheus::Exposer> exposer;

  std::vector<MetricFamily> Collect() const override {
    const Figures now = figures.Get();
    return now.status ? MetricFamilies(*now.status, now.totals) : std::vector<MetricFamily>();
  }

  void Open(std::uint16_t port) {
    const std::string address = "127.0.0.1:" + std::to_string(port);
    try {
      exposer.emplace(std::vector<std::string>{"listening_ports", address, "num_threads", kConnections,
                                               "request_timeout_ms", kRequestTimeoutMs, "enable_keep_alive", "no"});
    } catch (const std::exception& error) {
      spdlog::error("metrics are not offered at http://{}/metrics: {}; is the port taken?", address, error.what());
    }
  }

  void Write(const std::string& text) {
    try {
      WriteWithoutWaiting(file, text, Durability::kUnsynced);
      file_trouble.Ended();
    } catch (const std::runtime_error& error) {
      const std::string log =
          file_trouble.Occurred("metrics cannot be written", error.what(), Clock::System().monotonic());
      if (!log.empty()) spdlog::error("{}", log);
    }
  }
};

Metrics::Metrics(const MetricsOptions& options) : impl_(std::make_shared<Impl>()) {
  impl_->file = options.file;
  if (options.port == 0) return;
  impl_->Open(options.port);
  if (impl_->exposer) impl_->exposer->RegisterCollectable(impl_);
}

Metrics::~Metrics() { impl_->exposer.reset(); }

void Metrics::Update(const StatusMessage& status) {
  impl_->figures.Update([&](Impl::Figures& figures) {
    figures.status = status;
    figures.totals.Add(status);
  });
  if (!impl_->file.empty()) impl_->Write(MetricsText(status, impl_->figures.Get().totals));
}

}  // namespace chequer
