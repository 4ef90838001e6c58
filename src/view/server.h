#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace chequer {

struct ViewServerOptions {
  std::string address = "127.0.0.1";  ///< it listens at
  std::uint16_t port = 8180;          ///< 0: any that is free
  std::vector<std::string> names;     ///< under which pages may ask, beside localhost and numbers
  std::string url;                    ///< of LCM, where no log is replayed
  std::filesystem::path log;          ///< empty: what is live
  std::filesystem::path page;         ///< folder of the page's files
  std::filesystem::path chart;        ///< the library of charts
  std::string version;
};

/// Serves the page, and feeds it from LCM or a log. Everything happens on the thread that calls Run.
///
/// Bounded whatever comes: connections, headers, messages of pages and times are limited; a page that does not read is
/// not written to, and holds one message at most. Where LCM cannot be opened it is tried again, and the page says so.
class ViewServer {
 public:
  /// Throws std::runtime_error naming what cannot be used: the port, the page's files, the log.
  explicit ViewServer(const ViewServerOptions& options);
  ~ViewServer();

  /// "http://127.0.0.1:8180/".
  std::string url() const;

  /// Serves until Stop was called.
  void Run();
  /// From a signal handler or any thread.
  void Stop();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace chequer
