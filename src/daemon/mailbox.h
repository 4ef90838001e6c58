#pragma once

#include <mutex>
#include <optional>
#include <utility>

#include "core/unique_fd.h"
#include "publish/messages.h"

namespace chequer {

/// What the pipeline's threads leave for the main thread, which waits on a descriptor. Any thread.
class Mailbox {
 public:
  struct Mail {
    std::optional<StatusMessage> status;  ///< the newest since the last Take
    bool ready = false;                   ///< ever since it was put
    bool finished = false;                ///< since the last Take
  };

  /// Throws std::system_error where the system has no descriptor left.
  Mailbox();

  void Put(const StatusMessage& status);
  void PutReady();
  void PutFinished();

  /// What has come since the last time.
  Mail Take();
  /// Readable while something is there.
  int fd() const { return wake_.get(); }

 private:
  template <typename Change>
  void Update(Change&& change);

  UniqueFd wake_;
  std::mutex mutex_;
  Mail mail_;
};

}  // namespace chequer
