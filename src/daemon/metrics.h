#pragma once

#include <memory>
#include <string>
#include <vector>

#include "daemon/metrics_options.h"
#include "publish/messages.h"

namespace prometheus {
struct MetricFamily;
}

namespace chequer {

/// Offers what status_t tells to Prometheus, in its text format: at http://127.0.0.1:PORT/metrics, in a file (for the
/// node exporter's textfile collector), or both. One thread; the endpoint answers on threads of its own.
class Metrics {
 public:
  /// That the endpoint cannot be opened is logged and no error: tracking goes on without.
  explicit Metrics(const MetricsOptions& options);
  ~Metrics();

  /// Takes the newest figures. That the file cannot be written is logged once a cause.
  void Update(const StatusMessage& status);

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;  ///< shared: prometheus asks whether what it collects from still lives
};

/// Adds up what status_t tells of a window only.
struct MetricTotals {
  std::vector<NamedCount> detections;

  void Add(const StatusMessage& status);
};

/// The figures of a status as Prometheus's families of metrics, each with the label camera; names begin with chequer_.
std::vector<prometheus::MetricFamily> MetricFamilies(const StatusMessage& status, const MetricTotals& totals);

/// The same in Prometheus's text format.
std::string MetricsText(const StatusMessage& status, const MetricTotals& totals);

}  // namespace chequer
