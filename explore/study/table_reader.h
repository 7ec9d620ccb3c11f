// Reads one TOML table and remembers what was requested, so that unknown keys are found. Private to study/.
#pragma once

#include "base/error.h"
#include "study/keys.h"

#include <fmt/format.h>
#include <set>
#include <toml++/toml.h>
#include <vector>

namespace explore::study {

// Keys that may stand above all tables, and the tables' own names.
std::vector<Key> root_keys();

class TableReader {
public:
    // what: "[[layers]] \"base\"", for messages.
    TableReader(const toml::table& table, std::string file, std::string what)
        : table_(table),
          file_(std::move(file)),
          what_(std::move(what)) {}

    // Keys that may stand here, requested or not: none of them is taken for a misspelt other one.
    template <class Keys>
    void expect(const Keys& keys) {
        for (const auto& info : keys) {
            expected_.emplace(info.key);
        }
    }

    void rename(std::string what) { what_ = std::move(what); }
    // Of a key that may be missing: whoever asks takes it.
    bool has(std::string_view key) {
        expected_.emplace(key);
        return table_.contains(key);
    }

    pave::Place place(std::string_view key) const {
        const toml::node* node = table_.get(key);
        const auto& source = node != nullptr ? node->source() : table_.source();
        return {.file = file_,
                .line = static_cast<int>(source.begin.line),
                .key = what_.empty() ? std::string(key) : what_ + (key.empty() ? "" : " ") + std::string(key)};
    }

    std::string text(std::string_view key, std::optional<std::string> fallback = {},
                     const std::string& allowed = "a text in quotes") {
        const toml::node* node = find(key, fallback.has_value(), allowed);
        if (node == nullptr) {
            return *fallback;
        }
        if (!node->is_string()) {
            throw wrong_type(key, *node, allowed);
        }
        return node->as_string()->get();
    }

    // One of a list of words; returns its index.
    std::size_t choice(std::string_view key, const std::vector<std::string>& words,
                       std::optional<std::size_t> fallback = {}) {
        const std::string word =
            text(key, fallback ? std::optional(words[*fallback]) : std::nullopt, pave::join(words) + ", in quotes");
        for (std::size_t i = 0; i < words.size(); ++i) {
            if (words[i] == word) {
                return i;
            }
        }
        const std::string near = pave::nearest_name(word, words);
        throw pave::Error(place(key), near.empty() ? "unknown word" : "unknown word, did you mean \"" + near + "\"?",
                          "\"" + word + "\"", pave::join(words));
    }

    std::size_t choice(const Key& key) {
        std::optional<std::size_t> fallback;
        if (key.default_value) {
            fallback = static_cast<std::size_t>(*key.default_value);
        }
        return choice(key, {key.choices.begin(), key.choices.end()}, fallback);
    }

    double number(const Key& key) { return number(key, key.low, key.high, key.low_is_open, key.default_value); }

    double number(std::string_view key, double low, double high, bool low_is_open,
                  std::optional<double> fallback = {}) {
        const std::string allowed = fmt::format("{} {} value <= {}", low, low_is_open ? "<" : "<=", high);
        const toml::node* node = find(key, fallback.has_value(), allowed);
        if (node == nullptr) {
            return *fallback;
        }
        if (!node->is_number()) {
            throw wrong_type(key, *node, "a number, " + allowed);
        }
        // A whole number may be one that no double holds exactly: toml++ then converts nothing.
        const double value =
            node->is_integer() ? static_cast<double>(node->as_integer()->get()) : node->as_floating_point()->get();
        if (!((low_is_open ? value > low : value >= low) && value <= high)) {
            // Design codes prescribe an incompressible layer, which has no stiffness matrix.
            const bool is_incompressible = value == 0.5 && high < 0.5 && key.starts_with("poisson");
            throw pave::Error(place(key), "value out of range", fmt::format("{}", value),
                              is_incompressible ? fmt::format("{}; for 0.5 use {}", allowed, high) : allowed);
        }
        return value;
    }

    int integer(std::string_view key, int low, int high, std::optional<int> fallback = {}) {
        const std::string allowed = fmt::format("a whole number, {} to {}", low, high);
        const toml::node* node = find(key, fallback.has_value(), allowed);
        if (node == nullptr) {
            return *fallback;
        }
        if (!node->is_integer()) {
            throw wrong_type(key, *node, allowed);
        }
        const auto value = node->as_integer()->get();
        if (value < low || value > high) {
            throw pave::Error(place(key), "value out of range", fmt::format("{}", value), allowed);
        }
        return static_cast<int>(value);
    }

    int integer(const Key& key) {
        std::optional<int> fallback;
        if (key.default_value) {
            fallback = static_cast<int>(*key.default_value);
        }
        return integer(key, static_cast<int>(key.low), static_cast<int>(key.high), fallback);
    }

    // True or false; false when it is missing.
    bool flag(std::string_view key) {
        const toml::node* node = find(key, true, "true or false");
        if (node != nullptr && !node->is_boolean()) {
            throw wrong_type(key, *node, "true or false");
        }
        return node != nullptr && node->as_boolean()->get();
    }

    std::vector<std::string> texts(std::string_view key) {
        const toml::node* node = find(key, false, "a list of texts");
        std::vector<std::string> list;
        if (node->is_array()) {
            for (const auto& item : *node->as_array()) {
                if (!item.is_string()) {
                    throw wrong_type(key, item, "a list of texts");
                }
                list.push_back(item.as_string()->get());
            }
            return list;
        }
        throw wrong_type(key, *node, "a list of texts");
    }

    // A list of numbers in the range of the key, not empty.
    std::vector<double> numbers(const Key& key) {
        const std::string allowed =
            fmt::format("a list of numbers, each {} {} value <= {}", key.low, key.low_is_open ? "<" : "<=", key.high);
        const toml::node* node = find(key, false, allowed);
        const toml::array* array = node->as_array();
        if (array == nullptr || array->empty()) {
            throw wrong_type(key, *node, allowed);
        }
        std::vector<double> list;
        for (const auto& item : *array) {
            if (!item.is_number()) {
                throw wrong_type(key, item, allowed);
            }
            const double value =
                item.is_integer() ? static_cast<double>(item.as_integer()->get()) : item.as_floating_point()->get();
            if (!((key.low_is_open ? value > key.low : value >= key.low) && value <= key.high)) {
                throw pave::Error(place(key), "value out of range", fmt::format("{}", value), allowed);
            }
            list.push_back(value);
        }
        return list;
    }

    // [[key]], possibly absent.
    std::vector<const toml::table*> tables(std::string_view key) {
        used_.insert(std::string(key));
        std::vector<const toml::table*> list;
        const toml::node* node = table_.get(key);
        if (node == nullptr) {
            return list;
        }
        if (node->is_array()) {
            for (const auto& item : *node->as_array()) {
                if (!item.is_table()) {
                    throw wrong_type(key, item, fmt::format("tables, each headed [[{}]]", key));
                }
                list.push_back(item.as_table());
            }
            return list;
        }
        throw wrong_type(key, *node, fmt::format("tables, each headed [[{}]]", key));
    }

    // [key], possibly absent.
    const toml::table* table(std::string_view key) {
        used_.insert(std::string(key));
        const toml::node* node = table_.get(key);
        if (node != nullptr && !node->is_table()) {
            throw wrong_type(key, *node, fmt::format("a table headed [{}]", key));
        }
        return node != nullptr ? node->as_table() : nullptr;
    }

    // Every key of the table must have been requested.
    void done() const { refuse_all_but(used_); }
    // Every key of the table is one of these.
    template <class Keys>
    void refuse_others(const Keys& keys) {
        expect(keys);
        refuse_all_but(expected_);
    }

private:
    void refuse_all_but(const std::set<std::string, std::less<>>& allowed) const {
        for (const auto& [key, node] : table_) {
            if (!allowed.contains(key.str())) {
                std::set<std::string, std::less<>> all = used_;
                all.insert(expected_.begin(), expected_.end());
                const std::vector<std::string> known(all.begin(), all.end());
                const std::string near = pave::nearest_name(key.str(), known);
                throw pave::Error(place(key.str()),
                                  near.empty() ? "unknown key" : "unknown key, did you mean \"" + near + "\"?",
                                  "\"" + std::string(key.str()) + "\"", pave::join(known));
            }
        }
    }

    const toml::node* find(std::string_view key, bool optional, const std::string& allowed) {
        used_.insert(std::string(key));
        const toml::node* node = table_.get(key);
        if (node == nullptr && !optional) {
            // A misspelt key is the likelier mistake than a forgotten one.
            for (const auto& [other, unused] : table_) {
                if (!used_.contains(other.str()) && !expected_.contains(other.str()) &&
                    pave::nearest_name(other.str(), {std::string(key)}) == key) {
                    throw pave::Error(place(other.str()), fmt::format("unknown key, did you mean \"{}\"?", key),
                                      "\"" + std::string(other.str()) + "\"",
                                      allowed.empty() ? std::string(key) : fmt::format("{} = {}", key, allowed));
                }
            }
            throw pave::Error(place(key), "this key is missing", {}, allowed);
        }
        return node;
    }

    pave::Error wrong_type(std::string_view key, const toml::node& node, const std::string& allowed) const {
        std::ostringstream kind;
        kind << node.type();
        return {place(key), "wrong type", "a value of type " + kind.str(), allowed};
    }

    const toml::table& table_;
    std::string file_;
    std::string what_;
    std::set<std::string, std::less<>> used_;
    std::set<std::string, std::less<>> expected_;
};

} // namespace explore::study
