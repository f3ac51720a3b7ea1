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


if __name__ == "__main__":
    run()
