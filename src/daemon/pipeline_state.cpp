#include "daemon/pipeline_state.h"

#include <utility>

namespace chequer {

void PipelineState::ReplaceSource(std::unique_ptr<FrameSource> with) {
  source = std::move(with);
  source_is_open = false;
  sequence.CameraReplaced();
  capture.state = CameraState::kWaiting;
  capture.source.clear();
  capture.message.clear();
}

void PipelineState::ReplacePublisher(std::unique_ptr<Publisher> with) {
  if (publisher) {
    former_publishers.sent += publisher->health().sent;
    former_publishers.failed += publisher->health().failed;
  }
  publisher = std::move(with);
}

}  // namespace chequer
