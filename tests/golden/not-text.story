world kitchen
length ÿþ
