#pragma once
/// State kept in memory: what a checkpoint does, without a file.
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "core/state.h"

namespace wick::test {

/// One walk with saving = true fills the store, later walks with saving = false restore from it.
class MemoryState final : public StateVisitor {
 public:
  bool saving = true;

  void raw(std::string_view name, ScalarType type, std::size_t rows, std::size_t columns, const void* data,
           FunctionRef<void*(std::size_t)> resize) override {
    Entry& entry = entries_[path_ + std::string(name)];
    const std::size_t row_bytes = columns * scalar_size(type);
    if (saving) {
      entry.rows = rows;
      entry.bytes.assign(static_cast<const char*>(data), static_cast<const char*>(data) + rows * row_bytes);
    } else {
      void* to = resize(entry.rows);
      if (!entry.bytes.empty()) std::memcpy(to, entry.bytes.data(), entry.bytes.size());
    }
  }
  void strings(std::string_view name, std::vector<std::string>& values) override {
    Entry& entry = entries_[path_ + std::string(name)];
    if (saving)
      entry.strings = values;
    else
      values = entry.strings;
  }
  void begin_group(std::string_view name) override { path_ += std::string(name) + "/"; }
  void end_group() override { path_.erase(path_.rfind('/', path_.size() - 2) + 1); }

 private:
  struct Entry {
    std::size_t rows = 0;
    std::vector<char> bytes;
    std::vector<std::string> strings;
  };
  std::map<std::string, Entry> entries_;
  std::string path_;
};

/// Goes on in `to` where `from` is, as a restart does.
template <class World>
void continue_from(World& from, World& to) {
  MemoryState store;
  from.visit(store);
  store.saving = false;
  to.visit(store);
  to.restored();
}

}  // namespace wick::test
