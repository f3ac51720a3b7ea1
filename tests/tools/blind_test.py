"""`plenum blind`: sets of cases, sealed and scored."""

import json

from command import CommandTest, run


class Blind(CommandTest):
    """A small set, answered by a diagnosis that reads the labels: it must score full marks."""

    def perfect(self, label):
        floor, gap = label["noise_floor_Pa"], label["recalibrated_gap_Pa"]
        left = (floor ** 2 + gap ** 2) ** 0.5
        effects = [{"id": e["id"], "confidence": 1.0, "aliases": []} for e in label["effects"]
                   if e["catalogued"] and e["alone_recalibrated_gap_Pa"] >= floor]
        verdict = "calibration" if gap < floor else "explained" if effects else "unexplained"
        if verdict == "calibration":
            effects = []
        closed = left if verdict == "unexplained" else floor
        return {"schema": "plenum-gap/1", "verdict": verdict, "effects": effects, "candidates": effects,
                "gap_kPa": {"recalibrated": left / 1e3, "with_effects": closed / 1e3},
                "equation": {"id": label["effects"][0]["equation"], "confidence": 1.0} if effects else None}

    def make(self, *options):
        self.done("blind", "generate", "--out", "set", "--cases", 10, "--seconds", 10, *options)
        (self.folder / "answers").mkdir()
        for path in sorted((self.folder / "set" / "labels").iterdir()):
            label = json.loads(path.read_text(encoding="utf-8"))
            self.write(f"answers/{path.name}", json.dumps(self.perfect(label)))

    def test_a_diagnosis_that_knows_the_labels_scores_full_marks(self):
        self.make()
        score = json.loads(self.done("blind", "score", "set", "--answers", "answers", "--json", "-"))
        self.assertEqual((score["cases"], score["missing_answers"], score["mistakes"]), (10, 0, []))
        self.assertEqual(score["top1_percent"]["all"]["percent"], 100)
        self.assertEqual(score["false_alarm_percent"]["percent"], 0)
        self.assertIn("truth \\ first answer", self.done("blind", "score", "set", "--answers", "answers"))

    def test_what_was_sealed_cannot_be_changed(self):
        self.make("--effect", "dead_time")
        label = self.folder / "set" / "labels" / "case-0003.json"
        label.write_text(label.read_text(encoding="utf-8").replace("dead_time", "spool_lag"), encoding="utf-8")
        self.refused(2, "blind", "score", "set", "--answers", "answers", says=["case-0003.json", "SHA-256", "changed"])

    def test_wrong_requests_and_answers_are_one_line(self):
        self.refused(2, "blind", says=["subcommand"])
        self.refused(2, "blind", "generate", "--out", "q", "--effect", "gremlin", says=["gremlin", "spool_lag"])
        self.refused(2, "blind", "generate", "--out", "q", "--effect", "dead_time", "--kind", "none", says=["dead_time"])
        self.refused(2, "blind", "generate", "--out", "q", "--tier", "4", says=["--tier", "4"])
        self.refused(2, "blind", "score", "set", "--answers", "answers", says=["answers", "no such folder"])
        self.done("blind", "generate", "--out", "set", "--cases", 1, "--seconds", 10)
        self.refused(2, "blind", "generate", "--out", "set", says=["set", "new folder"])
        (self.folder / "answers").mkdir()
        self.refused(2, "blind", "score", "set", "--answers", "answers", says=["case-0001.json"])
        self.write("answers/case-0001.json", "{}")
        self.refused(2, "blind", "score", "set", "--answers", "answers", says=["answers/case-0001.json", "schema"])


class Sealed(CommandTest):
    """`plenum diagnose` on small sets whose labels it has not got. Their seed is one that nothing was tuned on."""

    def scored(self, kind, cases):
        self.done("blind", "generate", "--out", kind, "--kind", kind, "--cases", cases, "--tier", 1, "--seconds", 15, "--seed", 20261229)
        (self.folder / "answers").mkdir()
        for case in sorted((self.folder / kind).glob("case-*")):
            self.done("diagnose", "--rig", case / "rig.toml", "--heldout", case / "heldout.csv", "--json", f"answers/{case.name}.json", case / "log.csv")
        score = json.loads(self.done("blind", "score", kind, "--answers", "answers", "--json", "-"))
        self.assertEqual((score["cases"], score["missing_answers"]), (cases, 0))
        return score

    def test_five_effects_are_named_first_and_alone(self):
        score = self.scored("one", 5)
        for measure in ["top1_percent", "singleton_correct_percent", "coverage_percent", "equation_named_percent"]:
            share = score[measure].get("all", score[measure])
            self.assertEqual((share["right"], share["of"]), (5, 5), f"{measure}: {score['mistakes']}")
        self.assertGreater(score["closed_median_percent"], 97)
        self.assertLess(score["calibration_error"], 0.05)

    def test_no_effect_is_no_alarm(self):
        alarms = self.scored("none", 3)["false_alarm_percent"]
        self.assertEqual((alarms["right"], alarms["of"]), (0, 3), "alarms")

    def test_what_the_catalogue_does_not_hold_is_unexplained_in_its_equation(self):
        flagged = self.scored("unknown", 1)["unknown_flagged_percent"]
        self.assertEqual((flagged["right"], flagged["of"]), (1, 1))
        answer = json.loads((self.folder / "answers/case-0001.json").read_text(encoding="utf-8"))
        label = json.loads((self.folder / "unknown/labels/case-0001.json").read_text(encoding="utf-8"))
        self.assertEqual((answer["verdict"], answer["effects"]), ("unexplained", []))
        self.assertEqual(answer["equation"]["id"], label["effects"][0]["equation"])
        self.assertNotEqual(answer["where"], [])
        self.assertRegex(answer["next_experiment"]["instruction"], r"Commands from [0-9.]+ to [0-9.]+ V\.\Z")


if __name__ == "__main__":
    run()
