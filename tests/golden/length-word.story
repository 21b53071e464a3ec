world kitchen
length many
maximize 1
